#pragma once

#include <string>
#include <vector>

#include "core/environment/environment.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/studies/contact/collision.hpp"
#include "experiments/studies/contact/floor.hpp"
#include "experiments/studies/contact/robustness.hpp"
#include "experiments/studies/contact/sphere.hpp"

namespace mss::studies::contact {

/// What a row compares with the law of contact: heights of bounces; the distance in which a push stops; the
/// distance slid down a slope in a second; and of a cube that lands spinning, the kinetic energy left at the
/// end, the deepest penetration, and the energy gained in flight.
enum class Study { bounce, stop, slope, rest, depth, flight };
const char* to_string(Study study);

enum class BodyKind { particle, block, thesis_cube };
const char* to_string(BodyKind body);

/// What `mss validate contact` computes: whether contact obeys the laws whose coefficients it is given, and
/// which methods hold a body on a floor.
struct ContactConfig {
  std::vector<ContactLaw> laws{ContactLaw::impulse, ContactLaw::penalty, ContactLaw::thesis};
  std::vector<std::string> integrators;        ///< for particles
  std::vector<std::string> block_integrators;  ///< for bodies, which take longer
  std::vector<double> restitutions;            ///< of bounces
  std::vector<double> frictions;               ///< of pushes
  std::vector<double> degrees;                 ///< between a push and the edges of the lattice
  std::vector<double> slope_frictions;         ///< on a slope of tan = 0.5
  double rest_seconds = 8;                     ///< simulated time of the spinning cube
  FloorConfig floor{};
  CollisionConfig collision{};  ///< nothing where methods are named: these studies have their own
  SphereConfig sphere{};        ///< likewise
  RobustnessConfig robustness{};
};
ContactConfig contact_config(const ExperimentOptions& options);

struct ContactTables {
  Table rows;
  Table rest;   ///< kinetic energy of the cube against time, by the charted method
  Table floor;  ///< a body on the floor by every method and step
  Table bars;
  Table balance;
  Table spheres;
  Table impacts;
  RobustnessTables robustness{};
  Status status = Status::ok;
};
ContactTables measure_contact(const ContactConfig& config, int processes, Journal& journal,
                              Progress& progress);

/// All tables under the names of their files.
std::vector<NamedTable> contact_files(ContactTables tables);

/// The method that charts show: `verlet` where it moved a block, else the first that did, or that moved a
/// particle. The rows must not be empty.
std::string charted_integrator(const Table& rows);
Drawings draw_contact(const std::vector<NamedTable>& tables);

/// By the law: how far a particle slides in a second on a slope of tan = 0.5 [m].
double expected_slide(double friction);

}  // namespace mss::studies::contact
