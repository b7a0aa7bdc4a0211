#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mss {

/// The known name that begins with `found`, else the one that is fewest edits (insert, delete, replace, swap
/// neighbours) away from it; empty if none are known.
std::string nearest(std::string_view found, const std::vector<std::string>& known);

/// Whether `a` may be a slip for `b`: it is how `b` begins, they begin with the same letters for more than
/// half of the longer, or edits of a third of its letters at most, or of one, lie between them.
bool are_alike(std::string_view a, std::string_view b);

/// "did you mean 'NAME'? " of the nearest known name; empty if none is alike.
std::string question(std::string_view found, const std::vector<std::string>& known);

/// Throws the InputError of find_named().
[[noreturn]] void throw_unknown(std::string_view name, const std::vector<std::string>& known,
                                std::string_view what, std::string_view list);

/// The member of a registry that has that name. Throws InputError that names the nearest known one; `what`
/// the members are, and their name in `mss list`, follow.
template <class Info>
const Info& find_named(const std::vector<Info>& all, std::string_view name, std::string_view what,
                       std::string_view list) {
  std::vector<std::string> known;
  for (const Info& info : all) {
    if (info.name == name) return info;
    known.push_back(info.name);
  }
  throw_unknown(name, known, what, list);
}

}  // namespace mss
