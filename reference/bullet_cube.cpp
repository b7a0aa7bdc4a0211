#include "reference/bullet_cube.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <vector>

namespace mss::reference {

struct BulletCube::Engine {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSoftBodyWorldInfo world;
  std::unique_ptr<btSoftBody> body;
};

std::string BulletCube::precision() { return sizeof(btScalar) == sizeof(float) ? "single" : "double"; }

std::string BulletCube::version() {
  return std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

BulletCube::BulletCube(const Body& body, const Vec3& gravity) : engine_(std::make_shared<Engine>()) {
  engine_->world.m_broadphase = &engine_->broadphase;
  engine_->world.m_dispatcher = &engine_->dispatcher;
  engine_->world.m_gravity = btVector3(btScalar(gravity[0]), btScalar(gravity[1]), btScalar(gravity[2]));
  engine_->world.m_sparsesdf.Initialize();
  std::vector<btVector3> nodes;
  std::vector<btScalar> masses;
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 x = body.rest_position(site);
    nodes.emplace_back(btScalar(x[0]), btScalar(x[1]), btScalar(x[2]));
    masses.push_back(btScalar(body.mass(site)));
  }
  engine_->body =
      std::make_unique<btSoftBody>(&engine_->world, int(nodes.size()), nodes.data(), masses.data());
  body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double, double) {
    engine_->body->appendLink(body.particle(a), body.particle(b));
  });
  engine_->body->updateLinkConstants();
}

BulletCube::~BulletCube() = default;

void BulletCube::step(double dt) {
  engine_->body->predictMotion(btScalar(dt));
  engine_->body->solveConstraints();
  engine_->body->integrateMotion();
}

Vec3 BulletCube::position(std::size_t particle) const {
  const btVector3& x = engine_->body->m_nodes[int(particle)].m_x;
  return {double(x.x()), double(x.y()), double(x.z())};
}

}  // namespace mss::reference
