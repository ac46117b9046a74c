// Between the messages of session.proto and the project's own terms.
#pragma once

#include "base/camera.h"
#include "base/light_stage.h"
#include "io/session.h"
#include "session.pb.h"

namespace lamella {

// `where` is prefixed to the field an Error names: "session.json: rig.cameras[0]".
Camera camera_from_message(const v1::Camera& message, const std::string& where);
v1::Camera message_from_camera(const Camera& camera);

std::vector<Led> leds_from_message(const v1::Rig& message, const std::string& where);

// A row-major 3x3 between the colours of two lights: it can be undone, and keeps grey light lit.
Mat33d colour_matrix_from(const google::protobuf::RepeatedField<double>& values,
                          const std::string& where);

v1::Frame message_from_frame(const Frame& frame);
v1::Rig message_from_rig(const Session& session);
v1::Session message_from_session(const Session& session);

}  // namespace lamella
