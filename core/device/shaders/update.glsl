// The update that methods make from an acceleration, see KickDrift in core/system/system.hpp.

uniform real kick_before, kick_after, drift_old, drift_new;

rvec3 kicked(rvec3 v_old, rvec3 a) { return (v_old + kick_before * a) + kick_after * a; }
rvec3 drifted(rvec3 x_old, rvec3 v_old, rvec3 v_end) { return x_old + drift_old * v_old + drift_new * v_end; }
