#include "base/ray_scene.h"

#include <embree3/rtcore.h>

#include <cstring>
#include <limits>

#include "base/error.h"

namespace lamella {

struct RayScene::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Embree() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

namespace {

template <class Element>
void upload(RTCGeometry geometry, RTCBufferType type, RTCFormat format,
            const std::vector<Element>& elements) {
  void* buffer =
      rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), elements.size());
  std::memcpy(buffer, elements.data(), elements.size() * sizeof(Element));
}

RTCRay make_ray(const Vec3& o, const Vec3& d, float near_mm, float far_mm) {
  RTCRay ray{};
  ray.org_x = o[0], ray.org_y = o[1], ray.org_z = o[2];
  ray.dir_x = d[0], ray.dir_y = d[1], ray.dir_z = d[2];
  ray.tnear = near_mm;
  ray.tfar = far_mm;
  ray.mask = 0xffffffffu;
  return ray;
}

}  // namespace

RayScene::RayScene(const std::vector<Vec3>& vertices_mm, const std::vector<cv::Vec3i>& triangles)
    : embree_(std::make_unique<Embree>()) {
  embree_->device = rtcNewDevice(nullptr);
  if (!embree_->device) throw Error(Fault::kBadInput, "embree", "no ray tracing device");
  embree_->scene = rtcNewScene(embree_->device);
  // Light must not leak through the edges that triangles share.
  rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  if (!triangles.empty()) {
    RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    upload(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, vertices_mm);
    upload(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree_->scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(embree_->scene);
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

bool RayScene::occluded(const Vec3& origin_mm, const Vec3& direction, float near_mm,
                        float far_mm) const {
  RTCRay ray = make_ray(origin_mm, direction, near_mm, far_mm);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene, &context, &ray);
  return ray.tfar < 0;
}

Hit RayScene::intersect(const Vec3& origin_mm, const Vec3& direction, float near_mm,
                        float far_mm) const {
  RTCRayHit query{};
  query.ray = make_ray(origin_mm, direction, near_mm, far_mm);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene, &context, &query);
  Hit hit;
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  hit.distance_mm = query.ray.tfar;
  hit.triangle = int(query.hit.primID);
  hit.u = query.hit.u;
  hit.v = query.hit.v;
  return hit;
}

}  // namespace lamella
