#include "io/discovery.h"

#include <avahi-client/client.h>
#include <avahi-client/lookup.h>
#include <avahi-common/address.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/simple-watch.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "base/error.h"

namespace lamella {

namespace {

constexpr char kServiceType[] = "_lamella._tcp";
constexpr size_t kMostRigs = 256;
constexpr size_t kMostText = 255;
constexpr int kSlice_ms = 50;

[[noreturn]] void fail(int error) {
  throw Error(Fault::kRig, "mDNS", avahi_strerror(error),
              "is avahi-daemon running? without it give --rig HOST:PORT to what talks to a rig");
}

// What came over the network is shown on terminals.
std::string printable(const std::string& text) {
  std::string clean = text.substr(0, kMostText);
  for (char& c : clean) c = c >= 0x20 && c < 0x7f ? c : '_';
  return clean;
}

std::string text_of(AvahiStringList* records, const char* key) {
  AvahiStringList* found = avahi_string_list_find(records, key);
  char* value = nullptr;
  if (!found || avahi_string_list_get_pair(found, nullptr, &value, nullptr) < 0 || !value)
    return "";
  const std::string text = printable(value);
  avahi_free(value);
  return text;
}

struct Search {
  AvahiClient* client = nullptr;
  std::vector<FoundRig> rigs;
};

// As avahi-client calls it.
void on_resolved(AvahiServiceResolver* resolver, AvahiIfIndex, AvahiProtocol,
                 AvahiResolverEvent event, const char* name, const char*, const char*, const char*,
                 const AvahiAddress* address, uint16_t port, AvahiStringList* records,
                 AvahiLookupResultFlags, void* context) {
  auto* search = static_cast<Search*>(context);
  if (event == AVAHI_RESOLVER_FOUND && search->rigs.size() < kMostRigs) {
    char number[AVAHI_ADDRESS_STR_MAX];
    avahi_address_snprint(number, sizeof number, address);
    FoundRig rig{printable(name), number + (":" + std::to_string(port)),
                 text_of(records, "version"), text_of(records, "fingerprint")};
    const auto same = [&](const FoundRig& r) { return r.address == rig.address; };
    if (std::none_of(search->rigs.begin(), search->rigs.end(), same)) search->rigs.push_back(rig);
  }
  avahi_service_resolver_free(resolver);
}

void on_browsed(AvahiServiceBrowser*, AvahiIfIndex interface, AvahiProtocol protocol,
                AvahiBrowserEvent event, const char* name, const char* type, const char* domain,
                AvahiLookupResultFlags, void* context) {
  auto* search = static_cast<Search*>(context);
  if (event != AVAHI_BROWSER_NEW) return;
  // Freed in on_resolved(), or with the client.
  avahi_service_resolver_new(search->client, interface, protocol, name, type, domain,
                             AVAHI_PROTO_INET, AvahiLookupFlags(0), on_resolved, search);
}

void on_client(AvahiClient*, AvahiClientState, void*) {}

}  // namespace

std::vector<FoundRig> find_rigs(double seconds, const std::function<bool()>& interrupted) {
  const std::unique_ptr<AvahiSimplePoll, decltype(&avahi_simple_poll_free)> poll(
      avahi_simple_poll_new(), &avahi_simple_poll_free);
  if (!poll) fail(AVAHI_ERR_NO_MEMORY);
  int error = 0;
  Search search;
  const std::unique_ptr<AvahiClient, decltype(&avahi_client_free)> client(
      avahi_client_new(avahi_simple_poll_get(poll.get()), AvahiClientFlags(0), on_client, nullptr,
                       &error),
      &avahi_client_free);
  if (!client) fail(error);
  search.client = client.get();
  if (!avahi_service_browser_new(client.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_INET, kServiceType,
                                 nullptr, AvahiLookupFlags(0), on_browsed, &search)) {
    fail(avahi_client_errno(client.get()));
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end && !(interrupted && interrupted())) {
    if (avahi_simple_poll_iterate(poll.get(), kSlice_ms) != 0) fail(AVAHI_ERR_DISCONNECTED);
  }
  return search.rigs;
}

}  // namespace lamella
