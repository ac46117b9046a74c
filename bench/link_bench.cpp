// Photographs from the rig's daemon to the host's client over TLS on loopback, beside a raw TLS
// stream of the same cipher between two processes, in the same run, by turns.
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <vector>

#include "base/error.h"
#include "firmware/test_calibration.h"
#include "io/link_client.h"
#include "link/rig_process.h"

namespace {

using namespace lamella;

constexpr int kRounds = 9;
constexpr int kRows = 14000;           // of the twin's photographs: 40 of 9.5 MB
constexpr size_t kBlockBytes = 16384;  // a TLS record, which is also what s_server writes
constexpr double kAsked = 0.9;

// What a stream took: time on the clock, and of a processor at either end. Where nothing else runs
// and each end has a processor of its own, the busier end's time is the time on the clock.
struct Cost {
  double wall_s = 0, sender_s = 0, receiver_s = 0;
  double busier_s() const { return std::max(sender_s, receiver_s); }
};

double processor_s(pid_t process) {
  clockid_t clock;
  timespec used{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return double(used.tv_sec) + used.tv_nsec * 1e-9;
}

Cost cost_of(pid_t sender, const std::function<void()>& act) {
  const double sender_s = processor_s(sender), receiver_s = processor_s(0);
  const auto began = std::chrono::steady_clock::now();
  act();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  return {wall.count(), processor_s(sender) - sender_s, processor_s(0) - receiver_s};
}

[[noreturn]] void fail(const std::string& what) {
  throw Error(Fault::kRig, "bench", what + " failed");
}

SSL* raw_end(const Identity& identity, bool server, int fd) {
  SSL_CTX* context = SSL_CTX_new(server ? TLS_server_method() : TLS_client_method());
  SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION);
  SSL_CTX_set_ciphersuites(context, "TLS_AES_128_GCM_SHA256");
  SSL_CTX_use_certificate(context, identity.certificate());
  SSL_CTX_use_PrivateKey(context, identity.key());
  SSL* tls = SSL_new(context);
  SSL_CTX_free(context);
  SSL_set_fd(tls, fd);
  if ((server ? SSL_accept(tls) : SSL_connect(tls)) != 1) fail("a raw handshake");
  return tls;
}

void serve_raw(const Identity& identity, int fd, const std::vector<size_t>& sizes) {
  const std::vector<uint8_t> bytes(*std::max_element(sizes.begin(), sizes.end()), 0x5a);
  SSL* tls = raw_end(identity, true, fd);
  for (const size_t size : sizes) {
    for (size_t at = 0; at < size; at += kBlockBytes) {
      const int block = int(std::min(kBlockBytes, size - at));
      if (SSL_write(tls, bytes.data() + at, block) != block) fail("a raw write");
    }
  }
  SSL_shutdown(tls);
  SSL_free(tls);
}

// A pair of connected TCP sockets on loopback.
void connect_pair(int ends[2]) {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  bind(listener, reinterpret_cast<sockaddr*>(&address), size);
  listen(listener, 1);
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  ends[0] = socket(AF_INET, SOCK_STREAM, 0);
  if (connect(ends[0], reinterpret_cast<sockaddr*>(&address), size) != 0) fail("a connection");
  ends[1] = accept(listener, nullptr, nullptr);
  close(listener);
}

Cost raw_cost(const Identity& identity, const std::vector<size_t>& sizes) {
  int ends[2];
  connect_pair(ends);
  const pid_t server = fork();
  if (server == 0) {
    serve_raw(identity, ends[1], sizes);
    _exit(0);
  }
  close(ends[1]);
  SSL* tls = raw_end(identity, false, ends[0]);
  size_t left = 0;
  for (const size_t size : sizes) left += size;
  std::vector<uint8_t> block(kBlockBytes);
  const Cost cost = cost_of(server, [&] {
    while (left > 0) {
      const int got = SSL_read(tls, block.data(), int(block.size()));
      if (got <= 0) fail("a raw read");
      left -= size_t(got);
    }
  });
  SSL_free(tls);
  close(ends[0]);
  waitpid(server, nullptr, 0);
  return cost;
}

// The daemon on its simulated hardware, paired with this program.
struct Link {
  explicit Link(const fs::path& folder) : twin(kRows) {
    fs::create_directory(folder / "rig");
    fs::permissions(folder / "rig", fs::perms::owner_all);
    std::ofstream(folder / "calibration.json") << calibration_text();
    identity = std::make_shared<const Identity>(folder / "host");
    write_private_file(folder / "rig" / "paired_hosts",
                       to_hex(identity->fingerprint()) + " bench\n");
    rigd = std::make_unique<testing::RigUnderTest>(std::vector<std::string>{
        "--twin", twin.path(), "--calibration", folder / "calibration.json", "--listen",
        "127.0.0.1:0", "--state", folder / "rig"});
    LinkOptions options;
    options.tls = TlsOptions{identity, kBurstProtocol, [](const Fingerprint&) { return true; }};
    client = std::make_unique<LinkClient>(rigd->address(), options);
    offers = client->offers(client->run_burst("bench", false, true));
  }

  testing::TestTwin twin;
  std::shared_ptr<const Identity> identity;
  std::unique_ptr<testing::RigUnderTest> rigd;
  std::unique_ptr<LinkClient> client;
  std::vector<v1::FrameOffer> offers;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// What this machine's disk takes of photographs that are written and synced one by one.
double disk_bytes_per_s(const fs::path& folder, const std::vector<size_t>& sizes) {
  constexpr size_t kPhotographs = 8;
  const std::vector<char> bytes(*std::max_element(sizes.begin(), sizes.end()), 0x5a);
  const auto began = std::chrono::steady_clock::now();
  for (size_t i = 0; i < kPhotographs; ++i) {
    const int fd = open((folder / std::to_string(i)).c_str(), O_WRONLY | O_CREAT | O_EXCL, 0600);
    if (fd < 0 || write(fd, bytes.data(), bytes.size()) != ssize_t(bytes.size()) ||
        fdatasync(fd) != 0) {
      fail("writing to the disk");
    }
    close(fd);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  return double(kPhotographs * bytes.size()) / wall.count();
}

struct Round {
  Cost link, raw;
  double ratio() const { return raw.wall_s / link.wall_s; }
  double busier_ratio() const { return raw.busier_s() / link.busier_s(); }
};

Round play_round(const Link& link, const std::vector<size_t>& sizes) {
  const Cost via_link = cost_of(link.rigd->pid(), [&] {
    for (const v1::FrameOffer& offer : link.offers) link.client->photograph(offer);
  });
  return {via_link, raw_cost(*link.identity, sizes)};
}

void print_row(const std::string& name, const Round& round, double megabytes) {
  fmt::print("  {:<6} {:>8.0f} {:>8.0f} {:>6.2f} {:>9.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>6.2f}\n",
             name, megabytes / round.link.wall_s, megabytes / round.raw.wall_s, round.ratio(),
             round.link.sender_s * 1e3, round.link.receiver_s * 1e3, round.raw.sender_s * 1e3,
             round.raw.receiver_s * 1e3, round.busier_ratio());
}

int bench(const fs::path& folder) {
  Link link(folder);
  std::vector<size_t> sizes;
  double megabytes = 0;
  for (const v1::FrameOffer& offer : link.offers) {
    sizes.push_back(offer.size_bytes());
    megabytes += offer.size_bytes() * 1e-6;
  }
  fmt::print("{} photographs, {:.0f} MB, TLS 1.3 on loopback, {} rounds by turns\n", sizes.size(),
             megabytes, kRounds);
  fmt::print(
      "No disk in it: the rig has them in memory, the host checks and drops them. This "
      "machine's\ndisk takes {:.0f} MB/s, written and synced.\n\n",
      disk_bytes_per_s(folder, sizes) * 1e-6);
  fmt::print("         speed, MB/s             processor time, ms\n");
  fmt::print("  round      link  raw TLS  ratio   link rig     host raw from       to  ratio\n");
  std::vector<double> ratios, busier;
  for (int i = 0; i < kRounds; ++i) {
    const Round round = play_round(link, sizes);
    print_row(std::to_string(i + 1), round, megabytes);
    ratios.push_back(round.ratio());
    busier.push_back(round.busier_ratio());
  }
  fmt::print(
      "\nmedian ratio {:.2f}, asked {:.2f}; of the busier end's processor time {:.2f}, which "
      "other load\non this machine spoils less\n",
      median(ratios), kAsked, median(busier));
  return median(ratios) >= kAsked ? 0 : 1;
}

}  // namespace

int main() {
  char name[] = "/tmp/lamella-bench-XXXXXX";
  const fs::path folder = mkdtemp(name);
  int exit_code = 3;
  try {
    exit_code = bench(folder);
  } catch (const Error& e) {
    fmt::print(stderr, "bench_link: {}\n", e.what());
  }
  fs::remove_all(folder);
  return exit_code;
}
