#include "calib/receive.h"

#include <tbb/task_group.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <mutex>
#include <semaphore>
#include <set>

#include "base/error.h"
#include "base/progress.h"
#include "calib/develop.h"
#include "calib/same_rig.h"
#include "io/json.h"
#include "io/raw12.h"
#include "io/session.h"
#include "io/session_rig.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

constexpr const char* kOtherCalibration =
    "`lamella rig recover --calibration FILE` fetches it with another";
constexpr int kFramesInFlight = 6;  // received and not yet on disk: bounds the memory

// What a burst of a rig is called in messages.
std::string name_of(const BurstSource& rig, const Burst& burst) {
  return rig.name() + ": burst " + std::to_string(burst.id);
}

[[noreturn]] void reject(const std::string& what, const std::string& problem) {
  throw Error(Fault::kRig, what, problem, "this rig and this host do not fit together");
}

std::string lower(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The rig's words in a message of ours are checked like any file, but are the rig's fault.
template <class Check>
void blame_rig(const std::string& name, const std::string& remedy, const Check& check) {
  try {
    check();
  } catch (const Error& e) {
    throw Error(Fault::kRig, name, e.what(), remedy);
  }
}

using Cameras = std::map<std::string, Camera>;

v1::Session read_calibration(BurstSource* rig, const Burst& burst, Cameras* cameras) {
  const std::string text = rig->calibration(burst);
  v1::Session manifest;
  blame_rig(name_of(*rig, burst), kOtherCalibration, [&] {
    Session session;
    manifest = calibration_from(text, "its calibration", &session);
    (*cameras)["left"] = session.left;
    if (session.right) (*cameras)["right"] = *session.right;
  });
  return manifest;
}

// The camera that took what is offered. `what` is the offer's name.
const Camera& check_offer(const std::string& what, const v1::FrameOffer& offer,
                          const Cameras& cameras) {
  const v1::Frame& frame = offer.frame();
  const auto camera = cameras.find(frame.camera());
  if (camera == cameras.end()) reject(what, "no such camera in its calibration");
  const std::optional<RawPixels> pixels = raw_pixels_named(frame.pixel_format());
  if (!pixels) {
    reject(what, "pixel_format \"" + frame.pixel_format() + "\" is none that can be developed");
  }
  if (int(offer.width()) != camera->second.width || int(offer.height()) != camera->second.height) {
    reject(what, std::to_string(offer.width()) + "x" + std::to_string(offer.height()) +
                     " pixels disagree with its calibration");
  }
  if (offer.size_bytes() != raw12_bytes(*pixels, offer.width(), offer.height())) {
    reject(what, std::to_string(offer.size_bytes()) + " bytes are not its pixels");
  }
  if (!(frame.gain_per_dn() > 0) || !std::isfinite(frame.gain_per_dn()) ||
      !std::isfinite(frame.black_level_dn())) {
    reject(what, "black_level_dn or gain_per_dn is missing or not a number");
  }
  return camera->second;
}

// What the manifest says of a developed frame.
v1::Frame developed_frame(const v1::Frame& raw) {
  v1::Frame frame = raw;
  frame.set_file(frame_file(raw));
  frame.clear_pixel_format();
  frame.clear_black_level_dn();
  frame.clear_gain_per_dn();
  return frame;
}

// Develops and writes in the background, a few at a time; the first failure comes out of add() or
// finish().
class DarkRoom {
 public:
  explicit DarkRoom(fs::path folder) : folder_(std::move(folder)) {}
  ~DarkRoom() { tasks_.wait(); }

  void add(const v1::FrameOffer& offer, const Camera& camera, std::vector<uint8_t> bytes) {
    places_.acquire();
    rethrow();
    const v1::Frame& frame = offer.frame();
    const RawFormat format{frame.black_level_dn(), frame.gain_per_dn(), camera.saturation,
                           *raw_pixels_named(frame.pixel_format())};
    const fs::path file = folder_ / frame_file(frame);
    const cv::Size size(camera.width, camera.height);
    tasks_.run([this, format, file, size, raw = std::move(bytes)] {
      try {
        write_exr_rgb(file, develop(raw, size, format), PixelType::kHalf);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
      }
      places_.release();
    });
  }

  void finish() {
    tasks_.wait();
    rethrow();
  }

 private:
  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }

  fs::path folder_;
  tbb::task_group tasks_;
  std::counting_semaphore<kFramesInFlight> places_{kFramesInFlight};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

// The camera of every photograph offered.
std::vector<Camera> check_offers(const std::string& name, const Cameras& cameras,
                                 const std::vector<v1::FrameOffer>& offers) {
  std::vector<Camera> of_offers;
  for (const v1::FrameOffer& offer : offers) {
    of_offers.push_back(check_offer(name + ": " + describe(offer), offer, cameras));
  }
  return of_offers;
}

void receive_photographs(BurstSource* rig, const fs::path& folder,
                         const std::vector<Camera>& cameras,
                         const std::function<void(int)>& progress, Reception* reception) {
  DarkRoom dark_room(folder);
  const Stopwatch watch;
  for (size_t i = 0; i < reception->offers.size(); ++i) {
    const v1::FrameOffer& offer = reception->offers[i];
    std::vector<uint8_t> bytes = rig->photograph(offer);
    reception->raw_bytes += bytes.size();
    dark_room.add(offer, cameras[i], std::move(bytes));
    progress(int(i) + 1);
  }
  dark_room.finish();
  reception->transfer_s = watch.seconds();
}

void add_frames(const std::string& name, Reception* reception) {
  std::vector<v1::Frame> frames;
  std::set<std::string> files;
  for (const v1::FrameOffer& offer : reception->offers) {
    frames.push_back(developed_frame(offer.frame()));
    if (!files.insert(frames.back().file()).second) {
      reject(name + ": " + describe(offer), "sent twice");
    }
    if (offer.frame().has_replaced_by()) {
      reception->retaken.push_back(describe(offer));
    } else if (offer.marked()) {
      reception->marked.push_back(describe(offer));
    }
  }
  std::stable_sort(frames.begin(), frames.end(), [](const v1::Frame& a, const v1::Frame& b) {
    return std::pair(a.camera(), a.step()) < std::pair(b.camera(), b.step());
  });
  v1::Session* manifest = &reception->manifest;
  manifest->clear_frames();
  manifest->clear_retaken();
  for (const v1::Frame& frame : frames) {
    *(frame.has_replaced_by() ? manifest->add_retaken() : manifest->add_frames()) = frame;
  }
}

void drop_regions(const std::string& name, Reception* reception) {
  if (!reception->manifest.has_regions()) return;
  reception->warnings.push_back(name + ": its calibration names regions (" +
                                reception->manifest.regions().file() +
                                "), of which a rig sends no picture: left out of the session");
  reception->manifest.clear_regions();
}

// Why a session of photographs that did arrive cannot be fitted; "" where it can.
std::string unfit_for(const fs::path& session) {
  try {
    require_burst(read_session(session));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace

std::string frame_file(const v1::Frame& frame) {
  std::string name = std::to_string(frame.step());
  if (name.size() < 2) name = "0" + name;
  name += "_" + lower(v1::Frame::Role_Name(frame.role()));
  const bool indexed = frame.role() == v1::Frame::FRINGE || frame.role() == v1::Frame::STRIPES;
  if (indexed) name += "_" + std::to_string(frame.index());
  name += "_" + lower(v1::Frame::Analyser_Name(frame.analyser()));
  if (!frame.has_replaced_by()) return "frames/" + frame.camera() + "/" + name + ".exr";
  name += "_shot_" + std::to_string(frame.shot());
  return "frames/retaken/" + frame.camera() + "/" + name + ".exr";
}

Reception receive_session(BurstSource* rig, const Burst& burst, const WholeFolder& folder,
                          const std::function<void(int)>& progress) {
  const std::string name = name_of(*rig, burst);
  Reception reception;
  Cameras cameras;
  reception.manifest = read_calibration(rig, burst, &cameras);
  reception.manifest.set_flashing_confirmed(burst.flashing_confirmed);
  reception.manifest.set_shortfall(burst.shortfall);
  reception.manifest.set_subject(burst.subject);  // the calibration's sat there for that
  drop_regions(name, &reception);
  const v1::Welcome* welcome = rig->answering();
  if (welcome && burst.just_taken) {
    blame_rig(name, kOtherCalibration, [&] { require_same_rig(*welcome, reception.manifest); });
  }
  reception.offers = rig->offers(burst);
  if (burst.shortfall.empty() && reception.offers.size() != burst.frame_count) {
    reject(name, "offers " + std::to_string(reception.offers.size()) + " of its " +
                     std::to_string(burst.frame_count) + " photographs");
  }
  add_frames(name, &reception);
  receive_photographs(rig, folder.path(), check_offers(name, cameras, reception.offers), progress,
                      &reception);
  reception.timing = rig->timing(burst);
  write_json(folder.path() / "timing.json", reception.timing, Defaults::kWritten);
  write_json(folder.path() / "session.json", reception.manifest);
  const std::string unfit = unfit_for(folder.path());
  if (burst.shortfall.empty() && !unfit.empty()) reject(name, folder.inside(unfit));
  reception.unfit = folder.in_place(unfit);
  return reception;
}

double largest_edge_error_us(const v1::TimingEdges& timing, Replaced replaced) {
  double largest = 0;
  for (const v1::TimedEdge& edge : timing.edges()) {
    if (edge.replaced() && replaced == Replaced::kNot) continue;
    largest = std::max(largest, std::abs(edge.actual_us() - edge.planned_us()));
  }
  return largest;
}

}  // namespace lamella
