// lamella twin: photographs of a subject with known layers, as a session or on demand.
#include <fmt/format.h>

#include <csignal>
#include <memory>
#include <optional>

#include "apps/commands.h"
#include "apps/process_interrupt.h"
#include "apps/process_killed.h"
#include "apps/report.h"
#include "base/error.h"
#include "base/progress.h"
#include "io/json.h"
#include "io/rig_message.h"
#include "io/whole_file.h"
#include "twin/rig.h"
#include "twin/server.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella::apps {

namespace {

constexpr double kMostDriftMm = 10;
constexpr double kMostSpreadPercent = 30;

struct TwinArguments {
  twin::Photographer::Options subject;
  std::string socket;
  fs::path out, truth_out, calibration_out;
  double drift_mm = 0, led_spread = 0;
  bool no_burst = false;
  bool json = false;
};

volatile std::sig_atomic_t stop_asked = 0;

void ask_to_stop(int) { stop_asked = 1; }

// A folder appears whole: nothing else is put into it.
void require_apart(const fs::path& folder, const fs::path& other) {
  if (!folder.empty() && !other.empty() && lies_in(other, folder)) {
    throw_bad_input(other.string(), "lies in " + folder.string() + ", another output",
                    "name a place outside it");
  }
}

void check(const TwinArguments& a) {
  if (a.out.empty() && a.socket.empty() && a.truth_out.empty() && a.calibration_out.empty()) {
    throw_bad_input("twin", "nothing to do",
                    "give --out, --truth-out, --calibration-out or --serve");
  }
  if (a.no_burst && a.socket.empty()) {
    throw_bad_input("--no-burst", "is of --serve", "give --serve with it");
  }
  require_apart(a.out, a.truth_out);
  require_apart(a.truth_out, a.out);
  require_apart(a.out, a.calibration_out);
  require_apart(a.truth_out, a.calibration_out);
  if (!(a.subject.noise >= 0 && a.subject.noise <= 100)) {
    throw_bad_input("--noise", std::to_string(a.subject.noise), "give a number from 0 to 100");
  }
  if (!(a.drift_mm >= 0 && a.drift_mm <= kMostDriftMm)) {
    throw_bad_input("--drift", fmt::format("{:g} mm", a.drift_mm),
                    fmt::format("give a number from 0 to {:g}", kMostDriftMm));
  }
  if (!(a.led_spread >= 0 && a.led_spread <= kMostSpreadPercent)) {
    throw_bad_input("--led-spread", fmt::format("{:g} %", a.led_spread),
                    fmt::format("give a number from 0 to {:g}", kMostSpreadPercent));
  }
  if (a.drift_mm > 0 && a.out.empty()) {
    throw_bad_input("--drift", "is of --out", "give --out with it");
  }
}

// What a twin makes it makes again; photographs and fits it does not. `marker`: what such a folder
// holds, `own`: what only a twin's does.
void begin_folder(const fs::path& place, const char* marker, const char* own,
                  std::optional<WholeFolder>* folder) {
  if (place.empty()) return;
  if (fs::exists(place / marker) && !fs::exists(place / own)) {
    throw_bad_input(place.string(),
                    fmt::format("holds {} and no {}, so no twin made it", marker, own),
                    "choose another place, or remove it yourself");
  }
  clear_half_written_beside(place);
  folder->emplace(place, marker);
}

void write_whole_session(WholeFolder* session, const twin::Photographer& photographer,
                         twin::Studio* studio) {
  twin::write_session(session->path(), photographer, studio);
  twin::write_truth(session->path() / "truth", photographer);
  fs::copy_file(session->path() / "truth" / "regions.png", session->path() / "regions.png");
  session->commit();
}

void print_report(const TwinArguments& a, const Session& rig, double seconds) {
  if (a.json) {
    print_json({{"session", a.out.string()},
                {"subject", rig.subject},
                {"width", rig.left.width},
                {"height", rig.left.height},
                {"seconds", seconds}});
  } else {
    fmt::print("wrote {}: {}, {} pixels in {:.1f} s\n", a.out.string(), rig.subject,
               size_words({rig.left.width, rig.left.height}), seconds);
  }
}

// A rig that only tests itself looks at the empty stage: how skin scatters need not be known well.
twin::Photographer::Options subject_of(const TwinArguments& a) {
  twin::Photographer::Options subject = a.subject;
  if (a.no_burst) subject.photons /= 40;
  return subject;
}

// The rig as calibrated, without what only a session has.
void write_calibration(const fs::path& file, Session rig) {
  rig.regions_file.clear();
  write_json(file, message_from_session(rig));
}

void run_twin(const TwinArguments& a) {
  check(a);
  const Stopwatch clock;
  if (a.socket.empty()) abandon_outputs_on_interrupt();
  std::unique_ptr<twin::LocalListener> listener;
  if (!a.socket.empty()) {
    std::signal(SIGTERM, ask_to_stop);
    std::signal(SIGINT, ask_to_stop);
    listener = std::make_unique<twin::LocalListener>(a.socket);
  }
  // Places that cannot be are refused before the long work.
  std::optional<WholeFolder> session, truth;
  begin_folder(a.out, "session.json", "truth", &session);
  begin_folder(a.truth_out, "layers.json", "kernels.npz", &truth);
  if (!a.calibration_out.empty()) {
    require_file_place(a.calibration_out);
    clear_half_written_beside(a.calibration_out);
  }
  twin::Photographer photographer(subject_of(a));
  photographer.set_drift(a.drift_mm);
  photographer.set_led_spread(a.led_spread / 100, a.subject.seed);
  twin::Studio studio(photographer, a.subject.seed);
  if (!a.calibration_out.empty()) write_calibration(a.calibration_out, photographer.rig());
  if (session) {
    session->blame_place([&] { write_whole_session(&*session, photographer, &studio); });
    print_report(a, photographer.rig(), clock.seconds());
  }
  if (listener) {
    std::printf("serving %s\n", a.socket.c_str());
    std::fflush(stdout);
  }
  if (truth) {  // connections wait meanwhile
    truth->blame_place([&] { twin::write_truth(truth->path(), photographer); });
    truth->commit();
  }
  if (listener) {
    // What a burst will most likely ask for; any other light is worked out when it comes.
    if (!a.no_burst) twin::prepare_burst(photographer.rig(), &studio);
    std::printf("prepared\n");
    std::fflush(stdout);
    twin::serve(*listener, photographer, &studio, [] { return stop_asked != 0; });
  }
}

}  // namespace

void add_twin(const Command& app, int*) {
  const auto a = std::make_shared<TwinArguments>();
  const Command command = app.add_command("twin", "Photographs of a subject with known layers");
  command.add_option("--subject", a->subject.subject, "head or sphere").shows_default();
  command.add_option("--skin", a->subject.skin, "layered, one_layer, no_single, dark or light")
      .shows_default();
  command.add_option("--seed", a->subject.seed, "Of the face, its skin and the noise")
      .check(fault_of_whole_number)
      .shows_default();
  command
      .add_option(
          "--scale", a->subject.scale,
          fmt::format("Times 600x750 pixels, {:g} to {:g}", twin::kLeastScale, twin::kLargestScale))
      .shows_default();
  command.add_option("--noise", a->subject.noise, "Times the sensor's noise, 0 to 100")
      .shows_default();
  command
      .add_option("--drift", a->drift_mm,
                  fmt::format("Of --out: mm that the subject moves evenly during the burst, to the "
                              "right, down and towards the cameras, 0 to {:g}",
                              kMostDriftMm))
      .shows_default();
  command
      .add_option("--led-spread", a->led_spread,
                  fmt::format("% by which the LEDs' strengths are off their calibration, one "
                              "deviation, 0 to {:g}",
                              kMostSpreadPercent))
      .shows_default();
  command.add_option("--out", a->out, "Folder of the new session");
  command.add_option("--serve", a->socket, "Local socket on which to answer a simulated rig");
  command.add_flag(
      "--no-burst", a->no_burst,
      "Of --serve: no burst will be asked for, so its light and its subject's skin are not "
      "worked out well");
  command.add_option("--truth-out", a->truth_out, "Folder of the truth alone");
  command.add_option("--calibration-out", a->calibration_out, "File of the rig's calibration");
  command.add_flag("--json", a->json, "Report on --out as JSON");
  command.runs([a] { run_twin(*a); });
}

}  // namespace lamella::apps
