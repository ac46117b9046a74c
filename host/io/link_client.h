// The host's end of the link to a rig (proto/link.proto): asks for a burst and receives it.
// A connection that breaks is made again and the transfer goes on from the byte it had reached;
// only a rig that stays away, or that answers wrongly, is an Error (kRig).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/burst_source.h"
#include "io/chunk_view.h"
#include "io/wire.h"

namespace lamella {

inline constexpr uint32_t kProtocolVersion = 1;

struct LinkOptions {
  double connect_s = 5;               // longest wait for a connection
  double reply_s = 15;                // longest silence within an answer
  double burst_margin_s = 60;         // beyond the planned length of a burst
  int retries = 6;                    // connections in a row that bring nothing, before giving up
  double backoff_s = 0.1;             // before the first retry; doubled for each one after it
  std::function<bool()> interrupted;  // true: give up at once
  std::optional<TlsOptions> tls;      // none: in the clear (paired_link.h says which)
  bool outlives_us = true;            // false: a simulated rig that ends with this program
  std::string once_interrupted;       // what is so then; empty: photographs stay on the rig
};

class LinkClient : public BurstSource {
 public:
  // Connects and greets. `address` is HOST:PORT; one that cannot be any is an Error (kBadInput), a
  // name that nobody knows too.
  explicit LinkClient(std::string address, LinkOptions options = {});

  std::string name() const override { return "rig " + address_; }
  const v1::Welcome& welcome() const { return welcome_; }
  const v1::Welcome* answering() const override { return &welcome_; }

  v1::Status status();

  // Lights off; drops a burst that is under way, clears a FAULT. The state after it.
  v1::Status abort();

  // Tests these parts of the rig (none: all) and waits for the end. `learn` takes the LEDs as they
  // are for the reference of later tests. `progress` gets what is read so far, again and again.
  v1::SelftestResult selftest(const std::vector<std::string>& only, bool learn,
                              const std::function<void(const v1::SelftestResult&)>& progress);

  std::vector<v1::HeldBurst> held() override;
  std::string calibration(const Burst& burst) override;

  // Runs a burst and waits for its end. Never asked for twice: light on a face is not retried.
  // A rig that still holds photographs refuses, unless they may be discarded.
  // More than three flashes a second are refused unless confirmed for this subject.
  Burst run_burst(const std::string& subject, bool discard_held = false,
                  bool flashing_confirmed = false);

  // The newest burst of which photographs are held.
  Burst held_burst();

  std::vector<v1::FrameOffer> offers(const Burst& burst) override;
  v1::BurstDone ending(const Burst& burst) override;
  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override;
  v1::TimingEdges timing(const Burst& burst) override;

  // The rest of a photograph's bytes, whose first ones are there already; `arrived` gets each part
  // once it is checked. The whole is not: its CRC32C is the caller's to compare.
  void continue_photograph(const v1::FrameOffer& offer, std::vector<uint8_t>* bytes,
                           const std::function<void(std::span<const uint8_t>)>& arrived);

  // The photograph is on this host's disk: the rig may forget it.
  void acknowledge(const v1::FrameOffer& offer);

  // A burst of which no photograph is left, its reason read: the rig may forget it.
  void release(uint64_t burst_id);

 private:
  struct Blob;

  // Something to be had over as many connections as it takes.
  struct Transfer {
    std::function<Break()> attempt;         // goes on from where it is
    std::function<size_t()> reached;        // bytes or items so far
    std::function<std::string()> position;  // the same in words, for when it ends there
    std::string remedy;                     // and what to do then
  };

  // Attempts over new connections until one succeeds, or `retries` in a row got no further.
  void persist(const Transfer& transfer);

  Break connect();
  Break greet();
  Break next_reply(double seconds, v1::Reply* reply);
  Break next_answer(v1::Reply* reply);
  void throw_refusal(const v1::Reply& reply) const;
  bool is_gone_already(const v1::Reply& reply) const;
  void fail_on_fault(const v1::Status& status) const;
  Break ask(v1::Request* request, v1::Reply* reply);
  v1::Reply asked(const std::string& what, v1::Request request);
  Break list_held(std::vector<v1::HeldBurst>* held);
  std::string after_a_cut() const;
  Break await_done(Burst* burst);
  void await_idle(const std::string& cut, Burst* burst);
  std::vector<v1::FrameOffer> list(const Burst& burst, v1::BurstDone* done);
  Break list_offers(const Burst& burst, std::vector<v1::FrameOffer>* offers, v1::BurstDone* done);
  void fetch(Blob* blob);
  Break continue_blob(Blob* blob);
  Break receive_chunk(ChunkView* chunk, v1::Reply* reply);
  Break next_chunk(Blob* blob, uint32_t sequence);
  Break more_edges(const Burst& burst, v1::TimingEdges* timing);
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy = "") const;
  [[noreturn]] void fail_to_connect(const std::string& broken) const;

  std::string address_;
  LinkOptions options_;
  Socket socket_;
  v1::Welcome welcome_;
  uint32_t request_id_ = 0;
  bool reached_ = false;     // the last connection was made, whatever answered there
  bool forgetting_ = false;  // what the rig has forgotten already it need not forget
};

}  // namespace lamella
