// The page of `mss reproduce`.
#include <gtest/gtest.h>

#include "experiments/harness/report.hpp"

namespace mss {
namespace {

TEST(Page, EncodesAndEscapes) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("M"), "TQ==");
  EXPECT_EQ(base64("Ma"), "TWE=");
  EXPECT_EQ(base64("Man"), "TWFu");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
  EXPECT_EQ(html_text("<a href=\"x\"> & y"), "&lt;a href=&quot;x&quot;&gt; &amp; y");
}

}  // namespace
}  // namespace mss
