#include "experiments/cli/number_list.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"

namespace mss::cli {
namespace {

TEST(NumberList, ReadsNumbersAndRangesOnceAndAscending) {
  EXPECT_EQ(parse_number_list("20,2:4,3,30", "--cells", 100), (std::vector{2, 3, 4, 20, 30}));
  EXPECT_EQ(parse_number_list("7", "--cells", 7), std::vector{7});
  EXPECT_EQ(parse_number_list("7:7", "--cells", 7), std::vector{7});
}

TEST(NumberList, QuotesTheItemItCannotUse) {
  for (const std::string bad :
       {"", "0", "-3", "8", "2:8", "0:3", "x", "2x", "2:", ":3", "2:3:4", "1.5", " 3", "99999999999"}) {
    for (const std::string& list : {bad, "2," + bad, bad + ",2"}) {
      try {
        parse_number_list(list, "--cells", 7);
        ADD_FAILURE() << "'" << list << "' was accepted";
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("--cells has the item '" + bad + "'"), std::string::npos)
            << error.what();
      }
    }
  }
  EXPECT_THROW(parse_number_list("5:2", "--cells", 7), InputError);
}

}  // namespace
}  // namespace mss::cli
