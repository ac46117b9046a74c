#include "fit/piece_merge.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <queue>
#include <tuple>

namespace lamella::fit {

namespace {

// Ordered by loss and then by place, so that equal losses have one order.
struct Pair {
  double loss;
  size_t a, b;                     // a < b
  int joined_a = 0, joined_b = 0;  // how often each had been joined when the loss was reckoned

  bool operator>(const Pair& other) const {
    return std::tie(loss, a, b) > std::tie(other.loss, other.a, other.b);
  }
};

double squared_difference(const SkinPiece& a, const SkinPiece& b) {
  double sum = 0;
  for (size_t i = 0; i < kPieceFigures; ++i) {
    sum += (a.figure[i] - b.figure[i]) * (a.figure[i] - b.figure[i]);
  }
  return sum;
}

class Merger {
 public:
  explicit Merger(std::vector<SkinPiece> pieces)
      : pieces_(std::move(pieces)), parent_(pieces_.size()), joined_(pieces_.size(), 0) {
    std::iota(parent_.begin(), parent_.end(), size_t(0));
  }

  void join_neighbours(double most_loss_mm2) {
    std::priority_queue<Pair, std::vector<Pair>, std::greater<>> queue;
    const auto push = [&](size_t a, size_t b) { queue.push(pair(std::min(a, b), std::max(a, b))); };
    for (size_t i = 0; i < pieces_.size(); ++i) {
      for (const size_t j : pieces_[i].neighbours) {
        if (i < j) push(i, j);
      }
    }
    while (!queue.empty() && queue.top().loss <= most_loss_mm2) {
      const Pair next = queue.top();
      queue.pop();
      if (!is_current(next)) continue;
      join(next.a, next.b);
      for (const size_t j : pieces_[next.a].neighbours) push(next.a, j);
    }
  }

  void join_any(const MergeRules& rules) {
    for (std::vector<size_t> left = roots(); left.size() > 1; left = roots()) {
      const Pair best = cheapest(left);
      if (best.loss <= rules.most_loss_mm2 || left.size() > rules.most) {
        join(best.a, best.b);
      } else if (const std::optional<size_t> small = smallest_wanting(left, rules)) {
        const size_t other = most_alike(*small, left);
        join(std::min(*small, other), std::max(*small, other));
      } else {
        return;
      }
    }
  }

  MergedPieces result() const {
    std::vector<size_t> left = roots();
    std::stable_sort(left.begin(), left.end(),
                     [&](size_t a, size_t b) { return pieces_[a].area_mm2 > pieces_[b].area_mm2; });
    MergedPieces out;
    std::vector<uint8_t> place(pieces_.size(), 0);
    for (const size_t i : left) {
      place[i] = uint8_t(out.regions.size());
      out.regions.push_back(pieces_[i]);
      out.regions.back().neighbours.clear();
    }
    for (size_t i = 0; i < pieces_.size(); ++i) out.region.push_back(place[root(i)]);
    return out;
  }

 private:
  Pair pair(size_t a, size_t b) const {
    const double area =
        pieces_[a].area_mm2 * pieces_[b].area_mm2 / (pieces_[a].area_mm2 + pieces_[b].area_mm2);
    return {area * squared_difference(pieces_[a], pieces_[b]), a, b, joined_[a], joined_[b]};
  }

  bool is_current(const Pair& p) const {
    return is_root(p.a) && is_root(p.b) && joined_[p.a] == p.joined_a && joined_[p.b] == p.joined_b;
  }

  bool is_root(size_t i) const { return parent_[i] == i; }

  size_t root(size_t i) const {
    while (!is_root(i)) i = parent_[i];
    return i;
  }

  std::vector<size_t> roots() const {
    std::vector<size_t> left;
    for (size_t i = 0; i < pieces_.size(); ++i) {
      if (is_root(i)) left.push_back(i);
    }
    return left;
  }

  // b becomes part of a.
  void join(size_t a, size_t b) {
    SkinPiece &into = pieces_[a], &from = pieces_[b];
    const double share = from.area_mm2 / (into.area_mm2 + from.area_mm2);
    for (size_t i = 0; i < kPieceFigures; ++i) {
      into.figure[i] += share * (from.figure[i] - into.figure[i]);
    }
    into.area_mm2 += from.area_mm2;
    into.peak_mm2 += from.peak_mm2;
    for (const size_t j : from.neighbours) {
      pieces_[j].neighbours.erase(b);
      if (j == a) continue;
      pieces_[j].neighbours.insert(a);
      into.neighbours.insert(j);
    }
    into.neighbours.erase(b);
    from.neighbours.clear();
    parent_[b] = a;
    ++joined_[a];
  }

  Pair cheapest(const std::vector<size_t>& left) const {
    Pair best = pair(left[0], left[1]);
    for (size_t i = 0; i < left.size(); ++i) {
      for (size_t j = i + 1; j < left.size(); ++j) {
        const Pair candidate = pair(left[i], left[j]);
        if (best > candidate) best = candidate;
      }
    }
    return best;
  }

  std::optional<size_t> smallest_wanting(const std::vector<size_t>& left,
                                         const MergeRules& rules) const {
    std::optional<size_t> smallest;
    for (const size_t i : left) {
      const SkinPiece& piece = pieces_[i];
      const bool wanting =
          piece.area_mm2 < rules.least_area_mm2 || piece.peak_mm2 < rules.least_peak_mm2;
      if (wanting && (!smallest || piece.area_mm2 < pieces_[*smallest].area_mm2)) smallest = i;
    }
    return smallest;
  }

  size_t most_alike(size_t piece, const std::vector<size_t>& left) const {
    const std::set<size_t>& beside = pieces_[piece].neighbours;
    std::optional<size_t> best;
    for (const size_t i : left) {
      if (i == piece || (!beside.empty() && !beside.contains(i))) continue;
      if (!best || squared_difference(pieces_[i], pieces_[piece]) <
                       squared_difference(pieces_[*best], pieces_[piece])) {
        best = i;
      }
    }
    return *best;
  }

  std::vector<SkinPiece> pieces_;
  std::vector<size_t> parent_;
  std::vector<int> joined_;
};

}  // namespace

MergedPieces merge_pieces(std::vector<SkinPiece> pieces, const MergeRules& rules) {
  Merger merger(std::move(pieces));
  merger.join_neighbours(rules.most_loss_mm2);
  merger.join_any(rules);
  return merger.result();
}

}  // namespace lamella::fit
