// Tables, CSV and files that are written whole or not at all.
#include "experiments/harness/table.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;
using Columns = std::vector<Column>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Table, NumbersReadBackExactly) {
  const std::vector<double> values{0.1,  1.0 / 3, 5e-324, 1.7976931348623157e308,
                                   -0.0, 3,       1e-5,   123456789.125};
  Table table(Columns{{"value", "m"}});
  for (const double v : values) table.add({v});
  const auto rows = parse_csv(table.csv());
  ASSERT_EQ(rows.size(), values.size() + 1);
  EXPECT_EQ(rows[0], std::vector<std::string>{"value"});
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double back = std::strtod(rows[i + 1][0].c_str(), nullptr);
    EXPECT_EQ(back, values[i]);
    EXPECT_EQ(std::signbit(back), std::signbit(values[i]));
  }
}

TEST(Table, IntegersReadBackExactly) {
  Table table(Columns{{"count"}});
  table.add({std::int64_t{9007199254740993}});  // not a double
  EXPECT_EQ(table.csv(), "count\n9007199254740993\n");
}

TEST(Table, QuotesOnlyWhatNeedsIt) {
  Table table(Columns{{"a"}, {"b,c"}});
  table.add({"plain text", "with, comma"});
  table.add({"with \"quotes\"", "two\nlines"});
  table.add({"", "x"});
  EXPECT_EQ(table.csv(),
            "a,\"b,c\"\nplain text,\"with, comma\"\n\"with \"\"quotes\"\"\",\"two\nlines\"\n,x\n");
  const auto rows = parse_csv(table.csv());
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"a", "b,c"}));
  EXPECT_EQ(rows[1], (std::vector<std::string>{"plain text", "with, comma"}));
  EXPECT_EQ(rows[2], (std::vector<std::string>{"with \"quotes\"", "two\nlines"}));
  EXPECT_EQ(rows[3], (std::vector<std::string>{"", "x"}));
}

TEST(Table, ReadsForeignLineEndsAndAMissingLastOne) {
  EXPECT_EQ(parse_csv("a,b\r\n1,2"), (std::vector<std::vector<std::string>>{{"a", "b"}, {"1", "2"}}));
  EXPECT_THROW(parse_csv("a,\"b"), InputError);
}

TEST(Table, MissingNumberNeedsAStatusThatSaysWhy) {
  for (const double missing : {nan, infinity, -infinity}) {
    Table without(Columns{{"value"}});
    EXPECT_THROW(without.add({missing}), std::logic_error);
    Table with(Columns{{"value"}, {"status"}});
    EXPECT_THROW(with.add({missing, "ok"}), std::logic_error);
    EXPECT_THROW(with.add({missing, ""}), std::logic_error);
    EXPECT_EQ(with.size(), 0U);
    with.add({missing, "non_finite"});
    EXPECT_EQ(with.csv(), "value,status\n,non_finite\n");
  }
}

TEST(Table, RejectsRowsOfAnotherWidthAndUnknownColumns) {
  Table table(Columns{{"a"}, {"b"}});
  EXPECT_THROW(table.add({1.0}), std::logic_error);
  table.add({std::int64_t{2}, "x"});
  EXPECT_EQ(table.number(0, "a"), 2.0);
  EXPECT_EQ(table.text(0, "b"), "x");
  EXPECT_THROW(table.number(0, "b"), std::logic_error);
  EXPECT_THROW(table.text(0, "a"), std::logic_error);
  EXPECT_THROW(table.number(0, "c"), std::logic_error);
}

class WriteAtomically : public ::testing::Test {
 protected:
  WriteAtomically()
      : directory_(fs::temp_directory_path() / ("mss-output-test-" + std::to_string(getpid()))) {}
  ~WriteAtomically() override { fs::remove_all(directory_); }
  std::size_t entries() const {
    return std::size_t(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
  }
  fs::path directory_;
};

TEST_F(WriteAtomically, MakesDirectoriesAndLeavesNothingBeside) {
  const fs::path file = directory_ / "a" / "b" / "rows.csv";
  write_atomically(file, "first");
  write_atomically(file, std::string("second\0third", 12));
  EXPECT_EQ(read_file(file), std::string("second\0third", 12));
  directory_ = directory_ / "a" / "b";
  EXPECT_EQ(entries(), 1U);
  directory_ = directory_.parent_path().parent_path();
}

TEST_F(WriteAtomically, FailureNamesTheFileAndKeepsWhatWasThere) {
  fs::create_directories(directory_ / "rows.csv" / "inside");  // a directory cannot be replaced by a file
  try {
    write_atomically(directory_ / "rows.csv", "new");
    FAIL() << "expected an InputError";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("rows.csv"), std::string::npos);
  }
  EXPECT_TRUE(fs::is_directory(directory_ / "rows.csv" / "inside"));
  EXPECT_EQ(entries(), 1U);  // no half-written file beside it
  EXPECT_THROW(write_atomically("/dev/null/rows.csv", "new"), InputError);
}

TEST(Table, ReadsBackWhatItWrote) {
  Table table({{"name"}, {"count"}, {"size", "m"}, {"empty"}, {"status"}});
  const double none = std::numeric_limits<double>::quiet_NaN();
  table.add({std::string("a, \"b\""), std::int64_t(3), 0.1, std::string(), std::string("ok")});
  table.add({std::string("007"), std::int64_t(-2), none, std::string(), std::string("too large")});
  table.add({std::string("c"), std::int64_t(1) << 60, 1e300, std::string(), std::string("ok")});
  const Table again = Table::read(table.csv(), "x.csv");
  EXPECT_EQ(again.csv(), table.csv());
  EXPECT_EQ(again.text(0, "name"), "a, \"b\"");
  EXPECT_EQ(again.text(1, "name"), "007");
  EXPECT_EQ(again.number(0, "count"), 3);
  EXPECT_EQ(again.number(0, "size"), 0.1);
  EXPECT_TRUE(std::isnan(again.number(1, "size")));
  EXPECT_EQ(again.text(2, "empty"), "");
  EXPECT_TRUE(std::isnan(again.number(2, "empty")));
  EXPECT_EQ(again.where("status", "ok").size(), 2U);
  EXPECT_EQ(again.where("count", -2.0).text(0, "name"), "007");
}

TEST(Table, SaysWhatIsWrongWithAFile) {
  const auto problem = [](const std::string& csv) -> std::string {
    try {
      Table::read(csv, "x.csv");
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(problem(""), "x.csv has no header");
  EXPECT_EQ(problem("a,b\n1,2\n3\n"), "x.csv:3: 1 cells for 2 columns");
  EXPECT_EQ(problem("a,status\n1,ok\n,ok\n"),
            "x.csv:3: a number is missing and the row's status does not say why");
}

}  // namespace
}  // namespace mss
