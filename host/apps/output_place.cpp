#include "apps/output_place.h"

#include <cctype>

#include "apps/process_killed.h"
#include "base/error.h"
#include "io/layer_maps.h"

namespace lamella::apps {

namespace {

// What a rig took is there once: no picture of a fit is worth it.
void require_not_captured(const fs::path& out, const fs::path& session) {
  if (lies_in(file_behind(out), session / "frames") || is_same_file(out, session / "timing.json")) {
    throw_bad_input(out.string(), "belongs to what the rig took", "name another file");
  }
}

// A name without an ending says nothing.
void require_ending(const fs::path& out, const std::string& ending) {
  std::string own = out.extension().string();
  for (char& c : own) c = char(std::tolower(static_cast<unsigned char>(c)));
  if (own.empty() || own == ending) return;
  throw_bad_input(out.string(), "what is written there is no " + own.substr(1) + " file",
                  "let its name end with " + ending);
}

}  // namespace

void prepare_output(const fs::path& out, const std::string& ending, const FittedInput& input) {
  require_file_place(out);
  std::vector<fs::path> read = files_of_layers(input.fit);
  read.insert(read.end(),
              {input.session / "session.json", input.session / "regions.png", input.view});
  for (const fs::path& file : read) {
    if (is_same_file(out, file)) {
      throw_bad_input(out.string(), "is read by this command", "name another file");
    }
  }
  require_not_captured(out, input.session);
  require_ending(out, ending);
  clear_half_written_beside(out);
}

}  // namespace lamella::apps
