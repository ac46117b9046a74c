#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench_figures.h"
#include "apps/bench_peers.h"
#include "apps/report.h"

namespace lamella::apps {

namespace {

// Of several rounds the least: what else a machine does takes nothing away.
double least_of(const std::vector<double>& seconds) {
  return seconds.empty() ? double(kNaN) : *std::min_element(seconds.begin(), seconds.end());
}

// A line of the comparison; NaN where one side does not have it.
struct PeerLine {
  std::string name, label, unit;
  double its, ours;
};

std::vector<PeerLine> lines_of(const Peer& peer) {
  std::vector<PeerLine> lines{
      {"seconds", "seconds", "s", least_of(peer.its.all), least_of(peer.ours.all)},
      {"seconds_without_files", "  without files", "s", least_of(peer.its.without_files),
       least_of(peer.ours.without_files)}};
  for (size_t i = 0; i < peer.figures.size(); ++i) {
    const BenchFigure& figure = bench_figures()[i];
    lines.push_back({figure.name, figure.label, figure.unit, peer.figures[i], peer.our_figures[i]});
  }
  return lines;
}

void put_seconds(const WorkSeconds& from, v1::BenchPeer::Work* to) {
  for (const double s : from.all) to->add_seconds_s(s);
  for (const double s : from.without_files) to->add_without_files_s(s);
}

void put_figures(const std::vector<double>& from, v1::BenchPeer::Work* to) {
  for (size_t i = 0; i < from.size(); ++i) {
    if (std::isfinite(from[i])) (*to->mutable_figures())[bench_figures()[i].name] = from[i];
  }
}

}  // namespace

std::string peer_csv(const std::vector<Peer>& peers) {
  std::string text = "peer,figure,unit,its,ours,its_over_ours\n";
  for (const Peer& peer : peers) {
    if (!peer.missing.empty()) continue;
    for (const PeerLine& line : lines_of(peer)) {
      if (!std::isfinite(line.its)) continue;
      text +=
          fmt::format("{},{},{},{},{},{}\n", peer.name, line.name, line.unit, csv_number(line.its),
                      csv_number(line.ours), csv_number(line.its / line.ours));
    }
  }
  return text;
}

std::string peer_table(const std::vector<Peer>& peers) {
  std::string text;
  for (const Peer& peer : peers) {
    if (!peer.missing.empty()) {
      text += fmt::format("{}: did not run: {}\n", peer.name, one_line(peer.missing));
      continue;
    }
    text += fmt::format("{}: {}\n  {:<26}{:>14}{:>14}{:>13}\n", peer.name, peer.work, "", peer.name,
                        "ours", "times ours");
    for (const PeerLine& line : lines_of(peer)) {
      if (!std::isfinite(line.its)) continue;
      text +=
          fmt::format("  {:<26}{:>14}{:>14}{:>13.3g}\n", line.label, with_unit(line.its, line.unit),
                      with_unit(line.ours, line.unit), line.its / line.ours);
    }
  }
  return text;
}

v1::BenchPeer message_from_peer(const Peer& peer) {
  v1::BenchPeer out;
  out.set_name(peer.name);
  out.set_work(peer.work);
  out.set_missing(peer.missing);
  put_seconds(peer.its, out.mutable_its());
  put_seconds(peer.ours, out.mutable_ours());
  put_figures(peer.figures, out.mutable_its());
  put_figures(peer.our_figures, out.mutable_ours());
  return out;
}

}  // namespace lamella::apps
