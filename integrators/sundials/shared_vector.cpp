#include "integrators/sundials/shared_vector.hpp"

#include <cmath>
#include <cstdlib>

namespace mss::sundials {

namespace {

/// Of a part: what a serial vector has, which its functions see, and more. SUNDIALS frees it.
struct Part {
  _N_VectorContent_Serial serial;
  const Communicator* ranks;
  double whole_length;
};

const Part& part(N_Vector v) { return *static_cast<const Part*>(v->content); }
const Communicator& ranks_of(N_Vector v) { return *part(v).ranks; }

/// Gives a serial vector's content more; nullptr where there is no memory, as SUNDIALS expects.
N_Vector extended(N_Vector v, const Communicator& ranks, double whole_length) {
  if (v == nullptr) return nullptr;
  auto* content = static_cast<Part*>(std::malloc(sizeof(Part)));
  if (content == nullptr) {
    N_VDestroy_Serial(v);
    return nullptr;
  }
  *content = {*static_cast<N_VectorContent_Serial>(v->content), &ranks, whole_length};
  std::free(v->content);
  v->content = content;
  return v;
}

N_Vector clone(N_Vector v) { return extended(N_VClone_Serial(v), ranks_of(v), part(v).whole_length); }
N_Vector clone_empty(N_Vector v) {
  return extended(N_VCloneEmpty_Serial(v), ranks_of(v), part(v).whole_length);
}

double smallest(N_Vector v, double of_part) { return -ranks_of(v).largest(-of_part); }

sunindextype whole_length(N_Vector v) { return sunindextype(part(v).whole_length); }
double dot(N_Vector a, N_Vector b) { return ranks_of(a).sum(N_VDotProd_Serial(a, b)); }
double max_norm(N_Vector v) { return ranks_of(v).largest(N_VMaxNorm_Serial(v)); }
double l1_norm(N_Vector v) { return ranks_of(v).sum(N_VL1Norm_Serial(v)); }
double minimum(N_Vector v) { return smallest(v, N_VMin_Serial(v)); }
double minimum_quotient(N_Vector a, N_Vector b) { return smallest(a, N_VMinQuotient_Serial(a, b)); }
double weighted_l2_norm(N_Vector v, N_Vector weights) {
  return std::sqrt(ranks_of(v).sum(N_VWSqrSumLocal_Serial(v, weights)));
}
double weighted_rms_norm(N_Vector v, N_Vector weights) {
  return weighted_l2_norm(v, weights) / std::sqrt(part(v).whole_length);
}
booleantype inverts(N_Vector v, N_Vector inverse) {
  return ranks_of(v).all(N_VInvTest_Serial(v, inverse) != 0) ? SUNTRUE : SUNFALSE;
}

}  // namespace

Vector shared_vector(sunindextype length, const Communicator& ranks, SUNContext context) {
  N_Vector v = N_VNew_Serial(length, context);
  if (!ranks.are_several()) return Vector(v);
  v = extended(v, ranks, ranks.sum(double(length)));
  if (v == nullptr) throw std::bad_alloc();
  v->ops->nvclone = clone;
  v->ops->nvcloneempty = clone_empty;
  v->ops->nvgetlength = whole_length;
  v->ops->nvdotprod = dot;
  v->ops->nvmaxnorm = max_norm;
  v->ops->nvwrmsnorm = weighted_rms_norm;
  v->ops->nvmin = minimum;
  v->ops->nvwl2norm = weighted_l2_norm;
  v->ops->nvl1norm = l1_norm;
  v->ops->nvinvtest = inverts;
  v->ops->nvminquotient = minimum_quotient;
  v->ops->nvwrmsnormmask = nullptr;  // those of other solvers than are used here
  v->ops->nvconstrmask = nullptr;
  v->ops->nvdotprodmulti = nullptr;
  return Vector(v);
}

}  // namespace mss::sundials
