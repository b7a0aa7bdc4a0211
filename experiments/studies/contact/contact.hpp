#pragma once

#include <string>
#include <vector>

#include "core/environment.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

/// What `mss validate contact` asks of contact: that it obeys the laws it is given coefficients of.
struct ContactConfig {
  std::vector<ContactLaw> laws{ContactLaw::impulse, ContactLaw::penalty, ContactLaw::thesis};
  std::vector<std::string> integrators;        ///< of particles
  std::vector<std::string> block_integrators;  ///< of bodies, which take longer
  std::vector<double> restitutions;            ///< of bounces
  std::vector<double> frictions;               ///< of pushes
  std::vector<double> degrees;                 ///< directions of pushes against the lattice
  std::vector<double> slope_frictions;         ///< on a slope of tan = 0.5
  double rest_seconds = 8;                     ///< that a spinning cube is watched for
  int threads = 1;
};
ContactConfig contact_config(const ExperimentOptions& options);

struct ContactTables {
  Table rows;
  Table rest;  ///< kinetic energy of the cube that comes to rest, against time
  Status status = Status::ok;
};
ContactTables measure_contact(const ContactConfig& config, Progress& progress);

/// The method that charts show.
std::string charted_integrator(const ContactConfig& config);
std::vector<NamedChart> contact_charts(const ContactTables& tables, const ContactConfig& config);

/// How far a particle slides in a second, by the law [m]; tan(slope) = 0.5.
double expected_slide(double friction);

}  // namespace mss::studies::contact
