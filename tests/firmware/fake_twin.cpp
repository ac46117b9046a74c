#include "fake_twin.h"

#include <pb_decode.h>
#include <pb_encode.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstring>

extern "C" {
#include "crc32c.h"
#include "wire.h"
}

namespace {

// Mean of cos^2 over [from, to] of an angle that runs linearly: by fine sums, as this is a check.
double mean_cos2(const lamella_v1_ExposureReport& report, double from_us, double to_us) {
  const int kSamples = 2000;
  double sum = 0;
  for (int i = 0; i < kSamples; i++) {
    const double t_us = from_us + (i + 0.5) / kSamples * (to_us - from_us);
    double angle_rad = M_PI_2;  // an empty list: crossed
    for (int k = 0; k < report.analyser_count; k++) {
      const lamella_v1_AnalyserSpan& span = report.analyser[k];
      if (t_us < span.from_us || t_us > span.to_us) continue;
      const double share = (t_us - span.from_us) / (span.to_us - span.from_us);
      angle_rad = span.from_rad + share * (span.to_rad - span.from_rad);
    }
    sum += std::cos(angle_rad) * std::cos(angle_rad);
  }
  return sum / kSamples;
}

double seen(const lamella_v1_ExposureReport& report, double from_us, double to_us) {
  return 0.5 * mean_cos2(report, from_us, to_us) + 0.5 / 2;
}

std::vector<uint8_t> pack(const std::vector<double>& row, int rows) {
  std::vector<uint16_t> samples;
  for (int y = 0; y < rows; y++) {
    for (const double radiance : row) {
      const auto dn = static_cast<uint16_t>(std::fmin(std::lround(radiance * kFakeWhiteDn), 4095));
      samples.insert(samples.end(), 3, dn);
    }
  }
  if (samples.size() % 2 != 0) samples.push_back(0);
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < samples.size(); i += 2) {
    bytes.push_back(samples[i] & 0xFF);
    bytes.push_back(samples[i] >> 8 | (samples[i + 1] & 0xF) << 4);
    bytes.push_back(samples[i + 1] >> 4);
  }
  return bytes;
}

bool receive_all(int socket, void* bytes, size_t count) {
  return recv(socket, bytes, count, MSG_WAITALL) == static_cast<ssize_t>(count);
}

bool send_all(int socket, const uint8_t* bytes, size_t count) {
  while (count > 0) {
    const ssize_t sent = send(socket, bytes, count, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes += sent;
    count -= static_cast<size_t>(sent);
  }
  return true;
}

}  // namespace

std::vector<double> fake_radiance(const lamella_v1_ExposureReport& report) {
  std::vector<double> row(kFakePixels, 0);
  for (int k = 0; k < report.leds_count; k++) {
    const lamella_v1_LedSpan& span = report.leds[k];
    const double weight = (span.off_us - span.on_us) / report.led_reference_us *
                          seen(report, span.on_us, span.off_us);
    for (int i = 0; i < kFakePixels - 1; i++) {
      const int code = span.codes.bytes[2 * i] | span.codes.bytes[2 * i + 1] << 8;
      row[i] += code / 4095.0 * weight;
    }
  }
  for (int k = 0; k < report.patterns_count; k++) {
    const lamella_v1_PatternSpan& span = report.patterns[k];
    const double black = 0.02;
    double value = span.kind == lamella_v1_PatternSpan_Kind_DARK ? 0 : 1;
    if (span.kind == lamella_v1_PatternSpan_Kind_BLACK) value = black;
    row.back() += value * (span.off_us - span.on_us) / report.projector_reference_us *
                  seen(report, span.on_us, span.off_us);
  }
  return row;
}

std::vector<double> unpack_first_row(const uint8_t* bytes) {
  std::vector<double> row;
  for (int i = 0; i < kFakePixels; i++) {
    const int sample = 3 * i;
    const uint8_t* at = bytes + sample / 2 * 3;
    const int dn = sample % 2 == 0 ? at[0] | (at[1] & 0xF) << 8 : at[1] >> 4 | at[2] << 4;
    row.push_back(dn / kFakeWhiteDn);
  }
  return row;
}

FakeTwin::FakeTwin(int rows, Mood mood) : rows_(rows), mood_(mood) {
  char name[] = "/tmp/lamella-fake-twin-XXXXXX";
  path_ = std::string(mkdtemp(name)) + "/socket";
  listener_ = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path_.c_str());
  bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address);
  listen(listener_, 16);
  thread_ = std::thread([this] { serve(); });
}

FakeTwin::~FakeTwin() {
  shutdown(listener_, SHUT_RDWR);
  if (host_ >= 0) shutdown(host_, SHUT_RDWR);
  thread_.join();
  close(listener_);
  unlink(path_.c_str());
  rmdir(path_.substr(0, path_.rfind('/')).c_str());
}

std::vector<lamella_v1_ExposureReport> FakeTwin::reports() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return reports_;
}

void FakeTwin::serve() {
  while ((host_ = accept(listener_, nullptr, nullptr)) >= 0) {
    while (answer_one(host_)) continue;
    close(host_.exchange(-1));
  }
}

bool FakeTwin::answer_one(int host) {
  uint8_t prefix[WIRE_LENGTH_BYTES];
  size_t length = 0;
  if (!receive_all(host, prefix, sizeof prefix) || !wire_get_length(prefix, &length)) return false;
  std::vector<uint8_t> message(length);
  if (!receive_all(host, message.data(), length)) return false;
  lamella_v1_ExposureReport report = lamella_v1_ExposureReport_init_zero;
  pb_istream_t stream = pb_istream_from_buffer(message.data(), length);
  if (!pb_decode(&stream, lamella_v1_ExposureReport_fields, &report)) return false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    reports_.push_back(report);
  }
  send_photograph(host, pack(fake_radiance(report), rows_));
  return mood_ != Mood::kHangsUpMidway;
}

void FakeTwin::send_photograph(int host, const std::vector<uint8_t>& bytes) {
  lamella_v1_PhotographHeader header = lamella_v1_PhotographHeader_init_zero;
  header.width = kFakePixels;
  header.height = static_cast<uint32_t>(rows_);
  std::strcpy(header.pixel_format, "RGB12P");
  header.size_bytes = static_cast<uint32_t>(bytes.size());
  header.crc32c = crc32c_extend(0, bytes.data(), bytes.size());
  header.gain_per_dn = 1 / kFakeWhiteDn;
  if (mood_ == Mood::kSaysError) std::strcpy(header.error, "the subject has left");
  if (mood_ == Mood::kDamagesBytes) header.crc32c ^= 1;
  if (mood_ == Mood::kIsTooLarge) header.size_bytes = 2000000000;
  uint8_t message[WIRE_LENGTH_BYTES + lamella_v1_PhotographHeader_size];
  pb_ostream_t stream =
      pb_ostream_from_buffer(message + WIRE_LENGTH_BYTES, lamella_v1_PhotographHeader_size);
  pb_encode(&stream, lamella_v1_PhotographHeader_fields, &header);
  wire_put_length(message, stream.bytes_written);
  send_all(host, message, WIRE_LENGTH_BYTES + stream.bytes_written);
  if (mood_ == Mood::kSaysError) return;
  send_all(host, bytes.data(), mood_ == Mood::kHangsUpMidway ? bytes.size() / 2 : bytes.size());
}
