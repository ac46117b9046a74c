// What others need for the same work: the paper written in NumPy, and SciPy's solvers on the fit's
// own profiles (bench/peers). They run where this machine's python3 can.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/compare_confidence.h"
#include "io/session.h"
#include "layers.pb.h"

namespace lamella::apps {

// Of one piece of work, every round.
struct WorkSeconds {
  std::vector<double> all;  // reading and writing included
  std::vector<double> without_files;
};

struct Peer {
  std::string name;     // "NumPy"
  std::string work;     // what it does, and what is ours against it
  std::string missing;  // why it did not run; empty where it did
  WorkSeconds its, ours;
  std::vector<double> figures, our_figures;  // as bench_figures(); empty until it ran
};

// A fit of ours in the same round.
struct OurFit {
  double seconds, writing_s;
  std::vector<double> figures;
  std::vector<ConfidenceCurve> confidence;
};

class PeerBench {
 public:
  // Files lie in `scratch`, which is removed with it.
  PeerBench(const Session& session, const fs::path& scratch);
  ~PeerBench();
  PeerBench(const PeerBench&) = delete;
  PeerBench& operator=(const PeerBench&) = delete;

  // Every peer once, and what of ours is held against it.
  void run_round(const OurFit& ours);

  const std::vector<Peer>& peers() const { return peers_; }

 private:
  void run_numpy(const OurFit& ours, Peer* peer);
  void run_scipy(Peer* peer);

  struct Profiles;
  const Session& session_;
  fs::path scratch_;
  std::vector<Peer> peers_;
  std::unique_ptr<Profiles> profiles_;
};

// For programs and for people.
std::string peer_csv(const std::vector<Peer>& peers);
std::string peer_table(const std::vector<Peer>& peers);
v1::BenchPeer message_from_peer(const Peer& peer);

}  // namespace lamella::apps
