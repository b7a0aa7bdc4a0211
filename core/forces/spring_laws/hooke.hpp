// T = k (L - L0). What a law has is described in core/forces/spring_law.hpp.

MSS_SPRING_LAW(hooke, true)

MSS_FORMULA Number law_secant(MSS_UNUSED Number e) { return MSS_NUMBER(1); }
MSS_FORMULA Number law_tangent(MSS_UNUSED Number e) { return MSS_NUMBER(1); }
MSS_FORMULA Number law_energy(MSS_UNUSED Number e) { return MSS_NUMBER(1); }
