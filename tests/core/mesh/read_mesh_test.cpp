#include "core/mesh/read_mesh.hpp"
