#include "io/link_client.h"

#include <algorithm>
#include <random>
#include <thread>

#include "base/error.h"

namespace lamella {

namespace {

constexpr uint32_t kMaxFrames = 1024;
constexpr uint32_t kMaxBursts = 1024;
constexpr uint32_t kMaxEdges = 1u << 20;
constexpr double kPollStatus_s = 0.2;
constexpr double kLongestTest_s = 600;
constexpr double kLongestBurst_us = 600e6;  // nobody sits still for ten minutes
constexpr const char* kCheckLink = "check the rig's power and its network, then try again";

std::string number(uint64_t n) { return std::to_string(n); }

void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

}  // namespace

// A refusal is the rig's last word, so it is thrown; everything else may be tried again.
Break LinkClient::next_reply(double seconds, v1::Reply* reply) {
  while (true) {
    if (Break broken = socket_.receive(reply, deadline_in(seconds))) return broken;
    if (reply->request_id() != request_id_ && reply->request_id() != 0) continue;
    if (!is_gone_already(*reply)) throw_refusal(*reply);
    return {};
  }
}

// A rig that was asked before, by us over a link that broke, has nothing left to forget.
bool LinkClient::is_gone_already(const v1::Reply& reply) const {
  return forgetting_ && reply.refusal().code() == v1::Refusal::NOT_FOUND;
}

void LinkClient::throw_refusal(const v1::Reply& reply) const {
  if (!reply.has_refusal()) return;
  const v1::Refusal& refusal = reply.refusal();
  fail("refused (" + v1::Refusal::Code_Name(refusal.code()) + "): " + refusal.reason());
}

Break LinkClient::ask(v1::Request* request, v1::Reply* reply) {
  request->set_request_id(++request_id_);
  if (Break broken = socket_.send(*request, deadline_in(options_.reply_s))) return broken;
  return next_answer(reply);
}

// The next reply that is not an event.
Break LinkClient::next_answer(v1::Reply* reply) {
  do {
    if (Break broken = next_reply(options_.reply_s, reply)) return broken;
  } while (reply->request_id() == 0);
  return {};
}

void LinkClient::persist(const Transfer& transfer) {
  int idle = 0;
  while (true) {
    const size_t before = transfer.reached();
    Break broken = socket_.is_open() ? Break{} : connect();
    if (!broken) broken = transfer.attempt();
    if (!broken) return;
    socket_.close();
    idle = transfer.reached() > before ? 0 : idle + 1;
    const bool interrupted = options_.interrupted && options_.interrupted();
    if (idle > options_.retries || interrupted) {
      fail(transfer.position() + " (" + *broken + ")", transfer.remedy);
    }
    pause(options_.backoff_s * (1 << idle));
  }
}

v1::Reply LinkClient::asked(const std::string& what, v1::Request request) {
  v1::Reply reply;
  // Whoever has its photographs knows what is left to do.
  persist({[&] { return ask(&request, &reply); }, [] { return size_t(0); },
           [&] { return "link cut while asking for " + what; }, forgetting_ ? "" : kCheckLink});
  return reply;
}

v1::Status LinkClient::status() {
  v1::Request request;
  request.mutable_status();
  const v1::Reply reply = asked("its status", request);
  if (!reply.has_status()) fail("answered a question for its status with something else");
  return reply.status();
}

v1::Status LinkClient::abort() {
  v1::Request request;
  std::random_device chance;
  request.mutable_abort()->set_attempt(uint64_t(chance()) << 32 | chance() | 1);
  const v1::Reply reply = asked("an abort", request);
  if (reply.has_refusal()) throw_refusal(reply);
  if (!reply.has_status()) fail("answered an abort with something else");
  return reply.status();
}

v1::SelftestResult LinkClient::selftest(
    const std::vector<std::string>& only, bool learn,
    const std::function<void(const v1::SelftestResult&)>& progress) {
  v1::Request request;
  for (const std::string& part : only) request.mutable_selftest()->add_only(part);
  request.mutable_selftest()->set_learn(learn);
  v1::Reply reply;
  // Not asked for twice: what is under way is then asked after.
  if (Break broken = ask(&request, &reply))
    fail("link cut while starting the test (" + *broken + ")");
  const Deadline end = deadline_in(kLongestTest_s);
  request.Clear();
  request.mutable_selftest()->set_report(true);
  while (reply.has_selftest() && reply.selftest().running()) {
    if (std::chrono::steady_clock::now() > end) {
      fail("the self-test does not end, after " + number(uint64_t(kLongestTest_s)) + " s",
           kCheckLink);
    }
    progress(reply.selftest());
    pause(kPollStatus_s);
    reply = asked("its self-test", request);
  }
  if (!reply.has_selftest()) fail("answered a request for its self-test with something else");
  return reply.selftest();
}

Burst LinkClient::run_burst(const std::string& subject, bool discard_held,
                            bool flashing_confirmed) {
  v1::Request request;
  request.mutable_burst()->set_subject(subject);
  request.mutable_burst()->set_discard_held(discard_held);
  request.mutable_burst()->set_flashing_confirmed(flashing_confirmed);
  v1::Reply reply;
  const Break broken = ask(&request, &reply);
  if (broken) fail("link cut while starting the burst (" + *broken + ")", after_a_cut());
  if (!reply.has_accepted()) fail("answered the request for a burst with something else");
  Burst burst;
  burst.just_taken = true;
  burst.subject = subject;
  burst.flashing_confirmed = flashing_confirmed;
  burst.id = reply.accepted().burst_id();
  burst.step_count = reply.accepted().step_count();
  burst.planned_us = reply.accepted().planned_us();
  if (!(burst.planned_us >= 0 && burst.planned_us < kLongestBurst_us)) {
    fail("plans a burst of " + std::to_string(burst.planned_us) + " us");
  }
  if (const Break cut = await_done(&burst)) await_idle(*cut, &burst);
  return burst;
}

// Where a burst is to be had whose link was cut, and did not mend.
std::string LinkClient::after_a_cut() const {
  if (!options_.outlives_us) return "the simulated rig is gone, and its burst with it: start again";
  return "once the rig is back, lamella rig recover --rig " + address_ +
         " says what became of the burst, and lamella rig sync --rig " + address_ +
         " --out FOLDER fetches it";
}

Break LinkClient::await_done(Burst* burst) {
  const double longest_s = burst->planned_us * 1e-6 + options_.burst_margin_s;
  v1::Reply reply;
  do {
    if (Break broken = next_reply(longest_s, &reply)) return broken;
    fail_on_fault(reply.status());
  } while (!reply.has_done() || reply.done().burst_id() != burst->id);
  burst->frame_count = reply.done().frame_count();
  take_ending(reply.done(), burst);
  return {};
}

void LinkClient::fail_on_fault(const v1::Status& status) const {
  if (status.state() == v1::FAULT) fail("fault during the burst: " + status.fault());
}

// The connection broke during the burst, which goes on without us: ask until the rig is done. A rig
// that was off meanwhile has a part of the burst, or none of it.
void LinkClient::await_idle(const std::string& cut, Burst* burst) {
  const std::string what = "link cut during burst " + number(burst->id) + " (" + cut + ")";
  const Deadline end = deadline_in(burst->planned_us * 1e-6 + options_.burst_margin_s);
  v1::Request request;
  request.mutable_status();
  v1::Reply reply;
  do {
    if (std::chrono::steady_clock::now() > end) fail("the burst does not end", kCheckLink);
    socket_.close();
    persist({[&] { return ask(&request, &reply); }, [] { return size_t(0); },
             [&] { return what + ", and not mended"; }, after_a_cut()});
    fail_on_fault(reply.status());
    if (reply.status().state() != v1::IDLE) pause(kPollStatus_s);
  } while (reply.status().state() != v1::IDLE);
  const std::vector<v1::HeldBurst> all = held();
  const auto it = std::find_if(all.begin(), all.end(),
                               [&](const auto& h) { return h.burst_id() == burst->id; });
  if (it == all.end()) {
    fail(what + ": the rig was off meanwhile, and has nothing of it", "take the burst again");
  }
  if (!it->whole()) {
    fail(what + ": the rig was off meanwhile, and has a part of it (" + it->why() + ")",
         after_a_cut());
  }
  burst->frame_count = it->frames_held();
  take_ending(ending(*burst), burst);
}

Burst LinkClient::held_burst() {
  const std::vector<v1::HeldBurst> all = held();
  const auto newest = std::find_if(all.rbegin(), all.rend(),
                                   [](const v1::HeldBurst& h) { return h.frames_held() > 0; });
  if (newest != all.rend()) return burst_of(this, *newest);
  fail("holds no photographs", "run a burst");
}

std::vector<v1::FrameOffer> LinkClient::offers(const Burst& burst) {
  v1::BurstDone done;
  return list(burst, &done);
}

v1::BurstDone LinkClient::ending(const Burst& burst) {
  v1::BurstDone done;
  list(burst, &done);
  return done;
}

std::vector<v1::FrameOffer> LinkClient::list(const Burst& burst, v1::BurstDone* done) {
  std::vector<v1::FrameOffer> offers;
  persist({[&] { return list_offers(burst, &offers, done); }, [] { return size_t(0); },
           [&] {
             return "link cut in the list of photographs, after " + number(offers.size()) + " of " +
                    number(burst.frame_count);
           },
           after_a_cut()});
  return offers;
}

Break LinkClient::list_offers(const Burst& burst, std::vector<v1::FrameOffer>* offers,
                              v1::BurstDone* done) {
  offers->clear();
  v1::Request request;
  request.mutable_frames()->set_burst_id(burst.id);
  v1::Reply reply;
  if (Break broken = ask(&request, &reply)) return broken;
  while (!reply.has_done()) {
    if (!reply.has_frame()) return "something else came instead of an offer";
    if (offers->size() == kMaxFrames) fail("offers over " + number(kMaxFrames) + " photographs");
    offers->push_back(reply.frame());
    if (Break broken = next_answer(&reply)) return broken;
  }
  *done = reply.done();
  return {};
}

v1::TimingEdges LinkClient::timing(const Burst& burst) {
  v1::TimingEdges timing;
  persist({[&] { return more_edges(burst, &timing); }, [&] { return size_t(timing.edges_size()); },
           [&] { return "link cut in the timing, after edge " + number(timing.edges_size()); },
           after_a_cut()});
  return timing;
}

Break LinkClient::more_edges(const Burst& burst, v1::TimingEdges* timing) {
  do {
    v1::Request request;
    request.mutable_timing()->set_burst_id(burst.id);
    request.mutable_timing()->set_first_edge(uint32_t(timing->edges_size()));
    v1::Reply reply;
    if (Break broken = ask(&request, &reply)) return broken;
    const v1::TimingEdges& part = reply.timing();
    if (!reply.has_timing() || int(part.first_edge()) != timing->edges_size()) {
      return "something else came instead of the next edges";
    }
    if (part.total_edges() > kMaxEdges) fail("has " + number(part.total_edges()) + " edges");
    timing->set_total_edges(part.total_edges());
    timing->set_zero_us(part.zero_us());
    *timing->mutable_latency() = part.latency();
    timing->mutable_edges()->MergeFrom(part.edges());
    if (part.edges_size() == 0 && part.first_edge() < part.total_edges()) {
      return "no edges came where there should be more";
    }
  } while (timing->edges_size() < int(timing->total_edges()));
  return {};
}

void LinkClient::acknowledge(const v1::FrameOffer& offer) {
  v1::Request request;
  request.mutable_ack()->set_burst_id(offer.burst_id());
  request.mutable_ack()->set_frame_id(offer.frame_id());
  forgetting_ = true;
  const v1::Reply reply = asked("leave to forget " + describe(offer), request);
  forgetting_ = false;
  if (reply.has_refusal()) return;
  if (!reply.has_acknowledged() || reply.acknowledged().frame_id() != offer.frame_id()) {
    fail("did not acknowledge " + describe(offer));
  }
}

void LinkClient::release(uint64_t burst_id) {
  v1::Request request;
  request.mutable_burst_ack()->set_burst_id(burst_id);
  forgetting_ = true;
  const v1::Reply reply = asked("leave to forget burst " + number(burst_id), request);
  forgetting_ = false;
  if (!reply.has_refusal() && !reply.has_acknowledged()) {
    fail("did not forget burst " + number(burst_id));
  }
}

std::vector<v1::HeldBurst> LinkClient::held() {
  std::vector<v1::HeldBurst> held;
  persist({[&] { return list_held(&held); }, [] { return size_t(0); },
           [&] { return "link cut in the list of bursts, after " + number(held.size()); },
           kCheckLink});
  return held;
}

Break LinkClient::list_held(std::vector<v1::HeldBurst>* held) {
  held->clear();
  v1::Request request;
  request.mutable_bursts();
  v1::Reply reply;
  if (Break broken = ask(&request, &reply)) return broken;
  while (!reply.has_held_end()) {
    if (!reply.has_held()) return "something else came instead of a burst";
    if (held->size() == kMaxBursts) fail("holds over " + number(kMaxBursts) + " bursts");
    held->push_back(reply.held());
    if (Break broken = next_answer(&reply)) return broken;
  }
  return {};
}

}  // namespace lamella
