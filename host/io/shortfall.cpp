#include "io/shortfall.h"

#include "io/json.h"
#include "session.pb.h"

namespace lamella {

std::string read_shortfall(const std::filesystem::path& session) {
  v1::Session manifest;
  read_json(session / "session.json", &manifest);
  return manifest.shortfall();
}

}  // namespace lamella
