#include "apps/output_place.h"

#include "apps/process_killed.h"
#include "base/error.h"
#include "io/layer_maps.h"

namespace lamella::apps {

void prepare_output(const fs::path& out, const FittedInput& input) {
  require_file_place(out);
  std::vector<fs::path> read = files_of_layers(input.fit);
  read.insert(read.end(),
              {input.session / "session.json", input.session / "regions.png", input.view});
  for (const fs::path& file : read) {
    if (is_same_file(out, file)) {
      throw_bad_input(out.string(), "is read by this command", "name another file");
    }
  }
  clear_half_written_beside(out);
}

}  // namespace lamella::apps
