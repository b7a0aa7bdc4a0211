#pragma once

#include <cblas.h>
#include <omp.h>

namespace mss {

/// During its lifetime, parallel regions started by this thread have one thread, and so has the BLAS.
class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels()), blas_threads_(openblas_get_num_threads()) {
    omp_set_max_active_levels(0);
    if (blas_threads_ != 1) openblas_set_num_threads(1);
  }
  ~OneThread() {
    omp_set_max_active_levels(levels_);
    if (blas_threads_ != 1) openblas_set_num_threads(blas_threads_);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_;
  int blas_threads_;
};

}  // namespace mss
