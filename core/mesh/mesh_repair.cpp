#include "core/mesh/mesh_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace mss {

namespace {

/// An edge as a triangle has it.
struct EdgeUse {
  std::pair<int, int> edge;  ///< its vertices, the smaller first
  bool ascending;            ///< the triangle runs along it from the smaller to the larger
  int triangle;
};

/// The edges of all triangles, those of one edge together.
std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (a == b || b == c || c == a) continue;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      uses.push_back({std::minmax(from, to), from < to, int(t)});
  }
  std::ranges::sort(uses, {}, [](const EdgeUse& use) { return std::pair(use.edge, use.triangle); });
  return uses;
}

/// Calls visit(first, count) for the uses of each edge.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, Visit&& visit) {
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].edge == uses[begin].edge) ++end;
    visit(&uses[begin], end - begin);
  }
}

/// The vertices of edges that one triangle alone has, ascending.
std::vector<int> seam_vertices(const TriangleMesh& mesh) {
  std::vector<int> vertices;
  for_each_edge(edge_uses(mesh), [&](const EdgeUse* first, std::size_t count) {
    if (count == 1) vertices.insert(vertices.end(), {first->edge.first, first->edge.second});
  });
  std::ranges::sort(vertices);
  vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
  return vertices;
}

/// Points in cubes of the size of a distance, so that those within it are in the 27 cubes around.
class NearPoints {
 public:
  NearPoints(const Vec3& origin, double distance) : origin_(origin), distance_(distance) {}

  /// The first point that was added within the distance of x; -1 if there is none.
  int find(const std::vector<Vec3>& points, const Vec3& x) const {
    int found = -1;
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i beside(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      const auto cube = cubes_.find(key(x + distance_ * beside.cast<double>()));
      if (cube == cubes_.end()) continue;
      for (const int p : cube->second)
        if ((points[std::size_t(p)] - x).norm() < distance_ && (found < 0 || p < found)) found = p;
    }
    return found;
  }
  void add(int point, const Vec3& x) { cubes_[key(x)].push_back(point); }

 private:
  /// Of the cube of a point; that two cubes share one does no harm.
  std::uint64_t key(const Vec3& x) const {
    std::uint64_t key = 0;
    for (int a = 0; a < 3; ++a)
      key = (key ^ std::uint64_t(std::int64_t(std::floor((x[a] - origin_[a]) / distance_)))) *
            0x9e3779b97f4a7c15ULL;
    return key ^ key >> 32;
  }

  Vec3 origin_;
  double distance_;
  std::unordered_map<std::uint64_t, std::vector<int>> cubes_;
};

/// Which triangles to turn so that all of a patch face the way of its first triangle; patches one after the
/// other.
class Patches {
 public:
  explicit Patches(const TriangleMesh& mesh)
      : next_(mesh.triangles.size()), turn_(mesh.triangles.size(), unknown) {
    for_each_edge(edge_uses(mesh), [&](const EdgeUse* first, std::size_t count) {
      if (count != 2) return;
      const bool opposed = first[0].ascending == first[1].ascending;
      next_[std::size_t(first[0].triangle)].push_back({first[1].triangle, opposed});
      next_[std::size_t(first[1].triangle)].push_back({first[0].triangle, opposed});
    });
  }

  /// The triangles to turn.
  std::vector<int> find() {
    std::vector<int> all;
    for (int t = 0; t < int(turn_.size()); ++t)
      if (turn_[std::size_t(t)] == unknown)
        if (const std::vector<int> some = find_in_patch_of(t); !some.empty())
          all.insert(all.end(), some.begin(), some.end());
    return all;
  }

 private:
  static constexpr signed char unknown = -1;
  struct Neighbour {
    int triangle;
    bool opposed;  ///< it faces the other way
  };

  /// None where they face one way, and where they cannot.
  std::vector<int> find_in_patch_of(int first) {
    std::vector<int> patch{first};
    turn_[std::size_t(first)] = 0;
    for (std::size_t i = 0; i < patch.size(); ++i)
      for (const auto& [triangle, opposed] : next_[std::size_t(patch[i])]) {
        signed char& turn = turn_[std::size_t(triangle)];
        const auto wanted = static_cast<signed char>(turn_[std::size_t(patch[i])] ^ int(opposed));
        if (turn == unknown) {
          turn = wanted;
          patch.push_back(triangle);
        }
      }
    return is_one_sided(patch) ? std::vector<int>{} : the_fewer(patch);
  }

  bool is_one_sided(const std::vector<int>& patch) const {
    return std::ranges::any_of(patch, [&](int t) {
      return std::ranges::any_of(next_[std::size_t(t)], [&](const Neighbour& n) {
        return (turn_[std::size_t(t)] ^ int(n.opposed)) != turn_[std::size_t(n.triangle)];
      });
    });
  }

  std::vector<int> the_fewer(const std::vector<int>& patch) const {
    std::vector<int> turned, others;
    for (const int t : patch) (turn_[std::size_t(t)] == 1 ? turned : others).push_back(t);
    return turned.size() <= others.size() ? turned : others;
  }

  std::vector<std::vector<Neighbour>> next_;
  std::vector<signed char> turn_;  ///< by triangle: 0 or 1
};

}  // namespace

std::size_t weld_seams(TriangleMesh& mesh) {
  const std::vector<int> seam = seam_vertices(mesh);
  if (seam.empty()) return 0;
  const Box box = bounding_box(mesh);
  NearPoints kept(box.lower, std::max(weld_tolerance * (box.upper - box.lower).maxCoeff(), 1e-300));
  std::vector<int> joined_with(mesh.vertices.size());
  std::iota(joined_with.begin(), joined_with.end(), 0);
  std::size_t joined = 0;
  for (const int v : seam) {
    const Vec3& x = mesh.vertices[std::size_t(v)];
    if (const int near = kept.find(mesh.vertices, x); near >= 0) {
      joined_with[std::size_t(v)] = near;
      ++joined;
    } else {
      kept.add(v, x);
    }
  }
  TriangleMesh welded = mesh;
  std::erase_if(welded.triangles, [&](auto& t) {
    const bool had_area = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    for (int& v : t) v = joined_with[std::size_t(v)];
    return had_area && (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]);
  });
  if (joined == 0 || seam_vertices(welded).size() + joined >= seam.size()) return 0;
  mesh = merge_identical(welded);
  return joined;
}

std::size_t turn_alike(TriangleMesh& mesh) {
  const std::vector<int> turned = Patches(mesh).find();
  for (const int t : turned) std::swap(mesh.triangles[std::size_t(t)][1], mesh.triangles[std::size_t(t)][2]);
  return turned.size();
}

std::size_t inconsistent_edges(const TriangleMesh& mesh) {
  std::size_t edges = 0;
  for_each_edge(edge_uses(mesh), [&](const EdgeUse* first, std::size_t count) {
    if (count == 2 && first[0].ascending == first[1].ascending) ++edges;
  });
  return edges;
}

}  // namespace mss
