#pragma once

#include "experiments/harness/progress.hpp"

namespace mss {

/// Stops once so much has been reported.
class StopAfter final : public Progress {
 public:
  explicit StopAfter(int reports) : left_(reports) {}
  void report(double, std::string_view) override { --left_; }
  bool stopped() const override { return left_ <= 0; }

 private:
  int left_;
};

}  // namespace mss
