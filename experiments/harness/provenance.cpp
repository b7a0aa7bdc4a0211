#include "experiments/harness/provenance.hpp"

#include <H5public.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string_view>
#include <thread>

#include "core/base/thread_team.hpp"
#include "core/forces/spring_law.hpp"
#include "core/kernels/sweep.hpp"
#include "experiments/harness/build_info.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/harness/revision.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "integrators/linear/cholmod.hpp"
#include "integrators/sundials/version.hpp"

namespace mss {

namespace {

/// The text after `key` and a separator in the first line of a file that starts with it, as in "model name :
/// X".
std::string value_in(const char* file, std::string_view key, char separator) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(key, 0) != 0) continue;
    std::string value = line.substr(line.find(separator) + 1);
    value.erase(0, value.find_first_not_of(" \t\""));
    value.erase(value.find_last_not_of(" \t\"") + 1);
    return value;
  }
  return "unknown";
}

Json dependencies() {
  const std::string gnuplot = gnuplot_version();
  return {{"eigen", MSS_EIGEN_VERSION},
          {"fmt", MSS_FMT_VERSION},
          {"cli11", MSS_CLI11_VERSION},
          {"tomlplusplus", MSS_TOMLPLUSPLUS_VERSION},
          {"nlohmann_json", MSS_JSON_VERSION},
          {"benchmark", MSS_BENCHMARK_VERSION},
          {"cholmod", cholmod_version()},
          {"sundials", sundials::version()},
          {"hdf5", H5_VERS_INFO},
          {"openmp", MSS_OPENMP_VERSION},
          {"gnuplot", gnuplot.empty() ? "missing" : gnuplot}};
}

/// Settings that change what the OpenMP baseline costs.
Json openmp_settings() {
  Json settings = Json::object();
  for (const char* name : {"OMP_NUM_THREADS", "OMP_WAIT_POLICY", "OMP_PROC_BIND", "OMP_PLACES", "OMP_DYNAMIC",
                           "GOMP_SPINCOUNT", "GOMP_CPU_AFFINITY"})
    if (const char* value = std::getenv(name)) settings[name] = value;
  return settings;
}

Json sweep_kernel_names() {
  Json names = Json::array();
  for (const auto& kernel : runnable_copies<SweepKernel<double>>()) names.push_back(kernel.name);
  return names;
}

/// As in "AuthenticAMD, family 25, model 17": processors of one name differ, and the BLAS chooses by these.
std::string processor_model() {
  constexpr const char* file = "/proc/cpuinfo";
  return fmt::format("{}, family {}, model {}", value_in(file, "vendor_id", ':'),
                     value_in(file, "cpu family", ':'), value_in(file, "model\t", ':'));
}

std::string operating_system() {
  utsname system{};
  uname(&system);
  return fmt::format("{}, {} {} {}", value_in("/etc/os-release", "PRETTY_NAME", '='), system.sysname,
                     system.release, system.machine);
}

std::string version_text(const std::string& version, const std::string& commit, bool modified) {
  return fmt::format("{} (commit {}{})", version, commit.substr(0, 7), modified ? ", modified" : "");
}

/// Of the cores, what the run did not have. The load average at its start, which earlier versions recorded
/// alone, has in it what the run before left behind.
std::string load_text(const Json& p) {
  if (const auto others = other_work_in(p)) return fmt::format("{:.0f} % other work", 100 * others->share);
  return fmt::format("load {:.1f} at the start", p.at("load_average").at(0).get<double>());
}

}  // namespace

std::array<double, 3> load_average() {
  std::array<double, 3> load{};
  if (getloadavg(load.data(), int(load.size())) != int(load.size())) load.fill(0);
  return load;
}

Json provenance() {
  return {{"program", "mss"},
          {"version", MSS_VERSION},
          {"commit", MSS_COMMIT},
          {"modified", MSS_MODIFIED != 0},
          {"build_type", MSS_BUILD_TYPE},
          {"compiler", MSS_COMPILER},
          {"flags", MSS_FLAGS},
          {"sweep_flags", MSS_SWEEP_FLAGS},
          {"spring_law", SpringLaw::name},
          {"dependencies", dependencies()},
          {"cpu", value_in("/proc/cpuinfo", "model name", ':')},
          {"cpu_model", processor_model()},
          {"cores_available", available_cores()},
          {"cores_machine", std::thread::hardware_concurrency()},
          {"os", operating_system()},
          {"sweep_kernels", sweep_kernel_names()},
          {"blas_kernels", blas_kernels()},
          {"openmp_settings", openmp_settings()},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
          {"load_average", load_average()}};
}

std::string program_version() { return version_text(MSS_VERSION, MSS_COMMIT, MSS_MODIFIED != 0); }

std::string build_description() {
  return fmt::format("{}, {}, {}, {}, {}", program_version(), MSS_COMPILER, MSS_BUILD_TYPE, MSS_FLAGS,
                     MSS_SWEEP_FLAGS);
}

std::string spring_law_name() { return SpringLaw::name; }

std::string provenance_line(const Json& p) {
  return fmt::format("{}, {} cores, {} · {} · mss {} · {}", p.at("cpu").get<std::string>(),
                     p.at("cores_available").get<int>(), load_text(p), p.at("compiler").get<std::string>(),
                     version_text(p.at("version").get<std::string>(), p.at("commit").get<std::string>(),
                                  p.at("modified").get<bool>()),
                     p.at("date").get<std::string>());
}

}  // namespace mss
