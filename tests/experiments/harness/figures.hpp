#pragma once

#include <string>
#include <vector>

namespace mss {

/// A number, or several, that a text takes from a table: a link to the table whose title says from where, as
/// in
///
///   [7.6 and 2.2](refine/refine.csv "100 raw_error where problem=beam; cells=4|8")
///
/// Title: [min|max|median|sum] [abs] [factor] TERM [over|off TERM], or `count [where conditions]`. TERM is
/// [min of|max of|median of|sum of] column,column [where conditions]. A condition is a column, one of = != >=
/// <= > <, and a value, or several with bars between them; between conditions is "; ". `over` divides, row by
/// row, or by the one row there is; `off` is how far the quotient is from 1.
struct Figure {
  int line = 0;       ///< of the text
  std::string shown;  ///< what a reader sees
  std::string table;  ///< as the link has it
  std::string title;
};

/// The figures in a text: links to CSV files that have a title.
std::vector<Figure> figures_in(const std::string& markdown);

/// What is wrong with a figure, given the text of its table; empty if nothing is. Right is a figure whose
/// numbers are those of the table, in its order, each rounded to the digits shown; "A to B" are the smallest
/// and the largest.
std::string problem_with(const Figure& figure, const std::string& csv);

}  // namespace mss
