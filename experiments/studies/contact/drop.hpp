#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

/// Soft bodies of several shapes that fall into a box of five planes: cubes, slabs, balls and rings given by
/// meshes, and ragged blocks.
struct DropRun {
  int bodies = 0;
  std::string integrator;
  int threads = 1;
  double seconds = 0.75;

  std::string name() const;
};
/// The scene file of a run, whose meshes and voxels are in the folder of the scenes that come with the
/// program.
std::string drop_scene(const DropRun& run);

struct DropConfig {
  std::vector<DropRun> runs;
};
DropConfig drop_config(const ExperimentOptions& options);

Table empty_drop();
/// The run as a row: its times are of steps, a frame 1/60 s; pairs are vertices behind triangles, counted
/// each time that forces are computed. Its status is `ok`; `gains_energy`, more than a twentieth; `sinks_in`,
/// where contact may have lost a body; how the method ended; or `refused`.
void add_drop_run(const DropRun& run, Table& rows);

/// Time of a frame against the number of bodies.
Chart drop_chart(const Table& rows);

}  // namespace mss::studies::contact
