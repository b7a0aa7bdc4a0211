// In place of bullet_cube.cpp, where Bullet is not installed.
#include <stdexcept>

#include "reference/bullet_cube.hpp"

namespace mss::reference {

std::string BulletCube::version() { return ""; }
std::string BulletCube::precision() { return ""; }
BulletCube::BulletCube(const Body&, const Vec3&) { throw std::logic_error("built without Bullet"); }
BulletCube::~BulletCube() = default;
void BulletCube::step(double) {}
Vec3 BulletCube::position(std::size_t) const { return Vec3::Zero(); }

}  // namespace mss::reference
