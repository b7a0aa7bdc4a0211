#include "tests/fuzz/inputs.hpp"

#include <fmt/format.h>

#include "tests/fuzz/mutations.hpp"

namespace mss::fuzz {

namespace {

Kind kind_of(std::uint64_t index) {
  constexpr Kind kinds[]{Kind::scene,  Kind::scene, Kind::scene, Kind::scene,
                         Kind::voxels, Kind::obj,   Kind::stl,   Kind::ply};
  return kinds[index % 8];
}

void damage(Kind kind, std::string& text, const std::string& other, Random& random) {
  if (kind == Kind::scene) return damage_scene(text, other, random);
  if (kind == Kind::voxels) return damage_voxels(text, other, random);
  damage_mesh(kind, text, other, random);
}

}  // namespace

std::string scene_around(Kind kind, const std::string& file, std::size_t variant) {
  const std::string everywhere = "[[-1e15, -1e15, -1e15], [1e15, 1e15, 1e15]]";
  std::string text = kind == Kind::voxels ? fmt::format("[body]\nvoxels = \"{}\"\ncell_size = 0.1\n", file)
                                          : fmt::format("[body]\nmesh = \"{}\"\n", file);
  if (kind != Kind::voxels)
    text +=
        variant == 0 ? "cells_across = 3\n"
        : variant == 1
            ? "cells_across = 2.5\nfill = \"staircase\"\nmesh_rotation = { axis = [1, 1, 0], degrees = 30 }\n"
        : variant == 2 ? "cell_size = 0.3\ncontact_on = \"surface\"\n"
                       : "cells_across = 5\nmesh_scale = 0.1\n";
  text += "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n[environment]\ngravity = [0, 0, -9.81]\n";
  if (kind == Kind::voxels && variant < 2) text += "[[part]]\nname = \"A\"\nyoung = 2e5\n";
  if (variant == 2) text += "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\ncontact = \"penalty\"\n";
  if (variant == 3) text += "[[load]]\nbox = " + everywhere + "\nforce = [0, 0, -1]\n";
  return text + "[solve]\nintegrator = \"velocity_verlet\"\nduration = 0.1\n";
}

Input make_input(const Seeds& seeds, std::uint64_t seed, std::uint64_t index) {
  Random random(Random(seed).next() ^ index * 0xd1342543de82ef95ULL);
  Input input{.kind = kind_of(index), .files = {}, .overrides = {}};
  const std::vector<std::string>& texts = seeds.texts[std::size_t(input.kind)];
  std::string text = random.pick(texts);
  const std::string& other = random.pick(texts);
  do damage(input.kind, text, other, random);
  while (random.once_in(2));
  if (input.kind == Kind::scene && !random.once_in(6)) drop_repeated_keys(text);
  const std::string file = mutant_files[std::size_t(input.kind)];
  if (input.kind != Kind::scene)
    input.files["scene.toml"] = scene_around(input.kind, file, random.below(scene_variants));
  input.files[file] = std::move(text);
  if (random.once_in(input.kind == Kind::scene ? 8 : 64)) input.overrides.push_back(random_override(random));
  return input;
}

}  // namespace mss::fuzz
