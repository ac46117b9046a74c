#include "io/known_rigs.h"

#include <algorithm>

#include "base/error.h"

namespace lamella {

namespace {

constexpr size_t kMaxRigs = 256;
constexpr size_t kHexDigits = 64;
constexpr size_t kMaxWord = 255;

bool is_printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

std::optional<KnownRig> parse_line(const std::string& line) {
  if (line.size() <= kHexDigits || line[kHexDigits] != ' ') return {};
  const auto fingerprint = fingerprint_from_hex(line.substr(0, kHexDigits));
  const size_t space = line.find(' ', kHexDigits + 1);
  if (!fingerprint || space == std::string::npos || !is_printable(line)) return {};
  KnownRig rig{*fingerprint, line.substr(kHexDigits + 1, space - kHexDigits - 1),
               line.substr(space + 1)};
  const bool sound = !rig.address.empty() && rig.address.size() <= kMaxWord && !rig.name.empty() &&
                     rig.name.size() <= kMaxWord;
  return sound ? std::optional(rig) : std::nullopt;
}

}  // namespace

std::vector<KnownRig> KnownRigs::parse(const std::string& text, const std::string& where) {
  std::vector<KnownRig> rigs;
  int number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = text.find('\n', at);
    const std::string place = where + ":" + std::to_string(++number);
    const auto rig =
        end == std::string::npos ? std::nullopt : parse_line(text.substr(at, end - at));
    if (!rig) throw_bad_input(place, "not \"FINGERPRINT ADDRESS NAME\"", "remove the line");
    if (rigs.size() == kMaxRigs)
      throw_bad_input(place, "over 256 rigs", "`lamella rig pair --forget` those that are gone");
    rigs.push_back(*rig);
    at = end + 1;
  }
  return rigs;
}

KnownRigs::KnownRigs(const fs::path& folder) : path_(folder / "known_rigs") {
  if (const auto text = read_private_file(path_)) rigs_ = parse(*text, path_.string());
}

const KnownRig* KnownRigs::find(const Fingerprint& fingerprint) const {
  const auto it = std::find_if(rigs_.begin(), rigs_.end(),
                               [&](const KnownRig& r) { return r.fingerprint == fingerprint; });
  return it == rigs_.end() ? nullptr : &*it;
}

const KnownRig* KnownRigs::at(const std::string& address) const {
  const auto it = std::find_if(rigs_.begin(), rigs_.end(),
                               [&](const KnownRig& r) { return r.address == address; });
  return it == rigs_.end() ? nullptr : &*it;
}

void KnownRigs::add(const KnownRig& rig) {
  std::erase_if(rigs_, [&](const KnownRig& r) {
    return r.fingerprint == rig.fingerprint || r.address == rig.address;
  });
  rigs_.push_back(rig);
  // A name that came over the network is shown on terminals and stands in a file of lines.
  std::string& name = rigs_.back().name;
  for (char& c : name) c = c >= 0x20 && c < 0x7f ? c : '_';
  name.resize(std::min(name.size(), kMaxWord));
  if (name.empty()) name = "rig";
  write();
}

void KnownRigs::forget(const std::string& address) {
  std::erase_if(rigs_, [&](const KnownRig& r) { return r.address == address; });
  write();
}

void KnownRigs::write() const {
  std::string text;
  for (const KnownRig& r : rigs_)
    text += to_hex(r.fingerprint) + " " + r.address + " " + r.name + "\n";
  write_private_file(path_, text);
}

}  // namespace lamella
