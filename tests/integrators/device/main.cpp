// Skips all tests, saying why, where no device is.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/base/error.hpp"
#include "core/device/device.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    std::printf("on %s\n", mss::Device::open("gpu")->info().name.c_str());
  } catch (const mss::InputError& error) {
    std::printf("skipped: %s\n", error.what());
    return 77;
  }
  return RUN_ALL_TESTS();
}
