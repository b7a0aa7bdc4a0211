// What messages quote from files cannot break lines, move a terminal's cursor or be no text.
#include "core/base/error.hpp"

#include <gtest/gtest.h>

namespace mss::testing {
namespace {

TEST(Messages, LeaveTextsAsTheyAre) {
  for (const char* text : {"", "scene.toml:3: body.cells is missing", "Stra\u00dfe \u2264 \U0001F43B"})
    EXPECT_EQ(printable(text), text);
}

TEST(Messages, HaveNoControlCharacters) {
  EXPECT_EQ(printable("a\nb\r\tc\x1b[31m\x7f"), "a b  c [31m ");
  EXPECT_EQ(printable("\u0080\u009b\u00a0"), "  \u00a0");
  EXPECT_EQ(printable(std::string(1, '\0')), " ");
  EXPECT_STREQ(InputError("a\nb").what(), "a b");
}

TEST(Messages, AreUtf8) {
  EXPECT_EQ(printable("\xff\xc3(\xc0\xaf"), "\ufffd\ufffd(\ufffd\ufffd");
  EXPECT_EQ(printable("\xed\xa0\x80"), "\ufffd\ufffd\ufffd");            // a surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\ufffd\ufffd\ufffd\ufffd");  // beyond the last character
  EXPECT_EQ(printable("\xe2\x89"), "\ufffd\ufffd");                      // cut off
}

TEST(Messages, LoseTheirMiddleWhereTheyAreLong) {
  EXPECT_EQ(printable(std::string(2000, 'a')), std::string(2000, 'a'));
  EXPECT_EQ(printable("begin" + std::string(100000, 'a') + "end"),
            "begin" + std::string(992, 'a') + " ... " + std::string(994, 'a') + "end");
  std::string bears;
  for (int i = 0; i < 1000; ++i) bears += "\U0001F43B";
  const std::string shown = printable("a" + bears);
  EXPECT_LE(shown.size(), 2000U);
  EXPECT_TRUE(printable(shown) == shown);  // no character is cut
}

}  // namespace
}  // namespace mss::testing
