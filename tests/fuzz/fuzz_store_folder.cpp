// A rig's disk that is read on a host, as `lamella rig recover --store` does: files with any bytes,
// or sound records with any numbers in them beside photographs that may bear them out. What can be
// had becomes a session, or there is one line that says why not.
#include <fuzzer/FuzzedDataProvider.h>
#include <google/protobuf/stubs/logging.h>

#include <fstream>

#include "calib/receive.h"
#include "fuzz_input.h"
#include "io/crc32c.h"
#include "io/store_folder.h"

namespace {

using namespace lamella;
namespace fs = std::filesystem;

constexpr uint64_t kBurst = 1;
constexpr const char* kFiles[] = {"begin",           "end",
                                  "timing",          "frame-00.record",
                                  "frame-00.raw",    "frame-01.record.tmp",
                                  "frame-01.raw",    "frame-01.acked",
                                  "calibration.json"};
constexpr const char* kCalibration =
    R"({"format": "lamella.session.v1", "rig": {"leds": [{"direction": [0, 1, 0]}], "cameras": [)"
    R"({"id": "left", "width": 2, "height": 2, "fx": 5, "fy": 5, "cx": 1, "cy": 1,)"
    R"( "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "translation_mm": [0, 0, 500], "saturation": 1,)"
    R"( "read_noise": 0.01, "full_well_electrons": 1000}]}})";

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string little_endian(uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(char(value >> (8 * i)));
  return bytes;
}

std::string record_of(const std::string& message) {
  const std::string checked = "LMR1" + little_endian(uint32_t(message.size())) + message;
  return checked + little_endian(crc32c(checked.data(), checked.size()));
}

v1::FrameOffer any_offer(FuzzedDataProvider* data, uint32_t id, const std::string& raw) {
  v1::FrameOffer offer;
  offer.set_burst_id(kBurst);
  offer.set_frame_id(id);
  offer.set_width(data->ConsumeIntegralInRange(0, 4));
  offer.set_height(data->ConsumeIntegralInRange(0, 4));
  offer.set_size_bytes(uint32_t(raw.size()));
  offer.set_crc32c(crc32c(raw.data(), raw.size()) + data->ConsumeBool());
  v1::Frame* frame = offer.mutable_frame();
  frame->set_camera(data->ConsumeBool() ? "left" : "right");
  frame->set_pixel_format(data->ConsumeBool() ? "GREY12P" : data->ConsumeRandomLengthString(8));
  frame->set_step(data->ConsumeIntegral<uint32_t>());
  frame->set_role(v1::Frame::Role(data->ConsumeIntegralInRange(-1, 12)));
  frame->set_analyser(v1::Frame::Analyser(data->ConsumeIntegralInRange(-1, 3)));
  frame->set_gain_per_dn(data->ConsumeFloatingPoint<double>());
  frame->set_black_level_dn(data->ConsumeBool() ? 0 : data->ConsumeFloatingPoint<double>());
  if (data->ConsumeBool()) frame->set_replaced_by(data->ConsumeIntegral<uint32_t>());
  return offer;
}

void write_records(FuzzedDataProvider* data, const fs::path& burst) {
  v1::BurstBegin begin;
  begin.set_burst_id(kBurst);
  begin.set_frames_expected(data->ConsumeIntegral<uint32_t>());
  for (uint32_t id = 0; id < 2; ++id) {
    const std::string raw = data->ConsumeRandomLengthString(8);
    const std::string name = "frame-0" + std::to_string(id);
    write(burst / (name + ".raw"), raw);
    write(burst / (name + (data->ConsumeBool() ? ".record" : ".record.tmp")),
          record_of(any_offer(data, id, raw).SerializeAsString()));
  }
  v1::BurstEnd end;
  end.set_burst_id(kBurst);
  end.add_frame_ids(data->ConsumeIntegralInRange(0, 3));
  end.set_why(data->ConsumeRandomLengthString(10));
  write(burst / "end", record_of(end.SerializeAsString()));
  // A message of any bytes whose record is sound.
  write(burst / "timing", record_of(data->ConsumeRandomLengthString(40)));
  begin.set_subject(data->ConsumeRandomLengthString(70));
  write(burst / "begin", record_of(begin.SerializeAsString()));
}

void write_files(FuzzedDataProvider* data, const fs::path& burst) {
  while (data->remaining_bytes() > 0) {
    const std::string file = data->PickValueInArray(kFiles);
    write(burst / file, data->ConsumeRandomLengthString(400));
  }
}

// Of its own for each process; one on the disk would be most of the time.
struct Disk {
  std::string path =
      fs::exists("/dev/shm") ? "/dev/shm/lamella-fuzz-XXXXXX" : "/tmp/lamella-fuzz-XXXXXX";

  Disk() {
    if (!mkdtemp(path.data())) std::abort();
  }
  ~Disk() { fs::remove_all(path); }
};

void recover(const fs::path& place) {
  StoreFolder folder(place);
  for (const v1::HeldBurst& held : folder.held()) {
    if (held.whole() != held.why().empty()) std::abort();
    const fs::path session = place / "session";
    const WholeFolder received(session);
    receive_session(&folder, burst_of(&folder, held), received, [](int) {});
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the program does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const Disk disk;
  const fs::path store = disk.path;
  FuzzedDataProvider data(bytes, size);
  const fs::path burst = store / (data.ConsumeBool() ? "burst-000001" : "burst-000001.partial");
  fs::remove_all(store / "burst-000001");
  fs::remove_all(store / "burst-000001.partial");
  fs::create_directories(burst);
  write(burst / "calibration.json", kCalibration);
  if (data.ConsumeBool()) write_records(&data, burst);
  write_files(&data, burst);
  fuzz::expect_error_or_nothing([&] { recover(store); });
  return 0;
}
