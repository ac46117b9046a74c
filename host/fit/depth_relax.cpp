#include "fit/depth_relax.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "fit/order_statistics.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kDoubtfulSigmas = 2.f;  // of the median sigma
constexpr float kLeastFacing = 0.05f;   // more oblique, and a normal says nothing about depth
constexpr double kLinkSigmas = 1.5, kDataSigmas = 2.5;  // beyond, the other evidence is right
// First the wrong measurements are found. Links that are only given up in part tear a surface, so
// at the end each holds in full, or not at all, over a silhouette.
constexpr int kRobustRounds = 3;
constexpr double kFirstReach = 10;    // the first round believes links so many times further
constexpr double kFirstTrust = 0.05;  // and measurements so much less
constexpr double kAnchor = 1e-4;      // weight of the start, for islands without any evidence

using Matrix = Eigen::SparseMatrix<double>;

// Two neighbours, as places in the image, that should lie in one plane: a = ratio b.
struct Link {
  int a, b;
  double ratio, sigma_mm;
};

// Geman and McClure's weight of a residual, in sigmas.
double robust_weight(double residual, double sigma, double limit_sigmas) {
  const double x = residual / (limit_sigmas * sigma), y = 1 + x * x;
  return 1 / (sigma * sigma * y * y);
}

float median_sigma_mm(const DepthMap& measured) {
  std::vector<float> sigma;
  for (int y = 0; y < measured.sigma_mm.rows; y += 3) {
    for (int x = 0; x < measured.sigma_mm.cols; x += 3) {
      if (!std::isnan(measured.distance_mm(y, x))) sigma.push_back(measured.sigma_mm(y, x));
    }
  }
  return sigma.empty() ? 0 : median_of(&sigma);
}

class Relaxation {
 public:
  Relaxation(const DepthMap& measured, Image1* distance)
      : measured_(measured), distance_(*distance), unknown_(distance->size(), -1) {
    const Mask wanted = distance_ == distance_;
    Mask doubtful = wanted & ~(measured.distance_mm == measured.distance_mm);
    const int side = 2 * measured.penumbra_px + 1;
    cv::dilate(doubtful, doubtful, Mask::ones(side, side));
    doubtful |= measured.sigma_mm > kDoubtfulSigmas * median_sigma_mm(measured);
    doubtful &= wanted;
    for (int i = 0; i < int(doubtful.total()); ++i) {
      if (!doubtful.data[i]) continue;
      unknown_.at<int>(i / unknown_.cols, i % unknown_.cols) = int(place_.size());
      place_.push_back(i);
    }
  }

  long size() const { return long(place_.size()); }

  void link_neighbours(const Camera& camera, const SurfaceNormals& normals) {
    for (int y = 0; y < distance_.rows; ++y) {
      for (int x = 0; x < distance_.cols; ++x) {
        for (const cv::Point& step : {cv::Point(1, 0), cv::Point(0, 1)}) {
          link(camera, normals, {x, y}, cv::Point(x, y) + step);
        }
      }
    }
  }

  void solve(int rounds) {
    Eigen::SimplicialLDLT<Matrix> solver;
    for (int round = 0; round < rounds; ++round) {
      Matrix matrix(size(), size());
      const Eigen::VectorXd right = equations(round, &matrix);
      if (round == 0) solver.analyzePattern(matrix);
      solver.factorize(matrix);
      if (solver.info() != Eigen::Success) return;  // the last round's answer stays
      const Eigen::VectorXd solution = solver.solve(right);
      for (long k = 0; k < size(); ++k) mm(place_[size_t(k)]) = float(solution[k]);
    }
  }

 private:
  float& mm(int place) { return distance_(place / distance_.cols, place % distance_.cols); }
  int unknown(int place) const { return unknown_(place / distance_.cols, place % distance_.cols); }

  void link(const Camera& camera, const SurfaceNormals& normals, const cv::Point& a,
            const cv::Point& b) {
    if (b.x >= distance_.cols || b.y >= distance_.rows) return;
    if (unknown_(a) < 0 && unknown_(b) < 0) return;
    const Vec3 n = unit(normals.unit(a) + normals.unit(b));
    const double facing_a = -dot(n, Vec3(camera.ray(a.x, a.y)));
    const double facing_b = -dot(n, Vec3(camera.ray(b.x, b.y)));
    const double facing = std::min(facing_a, facing_b);
    if (!(facing > kLeastFacing) || std::isnan(distance_(a)) || std::isnan(distance_(b))) return;
    const double sigma_rad = std::max(normals.sigma_rad(a), normals.sigma_rad(b));
    links_.push_back({a.y * distance_.cols + a.x, b.y * distance_.cols + b.x, facing_b / facing_a,
                      measured_.px_mm * sigma_rad / (facing * facing)});
  }

  double link_weight(const Link& l, int round) {
    const double residual = mm(l.a) - l.ratio * mm(l.b);
    if (round < kRobustRounds) {
      return robust_weight(residual, l.sigma_mm, kLinkSigmas * (round == 0 ? kFirstReach : 1));
    }
    const bool is_whole = std::abs(residual) < silhouette_step_mm(1, measured_.px_mm);
    return is_whole ? 1 / (l.sigma_mm * l.sigma_mm) : 0;
  }

  double data_weight(int place, float data_mm, double sigma_mm, int round) {
    if (round == 0) return kFirstTrust / (sigma_mm * sigma_mm);
    return robust_weight(data_mm - mm(place), sigma_mm, kDataSigmas);
  }

  // Normal equations with this round's weights; returns the right side.
  Eigen::VectorXd equations(int round, Matrix* matrix) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right(size());
    for (long k = 0; k < size(); ++k) {
      const int i = place_[size_t(k)];
      const cv::Point at(i % distance_.cols, i / distance_.cols);
      const float data_mm = measured_.distance_mm(at);
      const bool has_data = !std::isnan(data_mm);
      const double w = has_data ? data_weight(i, data_mm, measured_.sigma_mm(at), round) : 0;
      entries.emplace_back(int(k), int(k), w + kAnchor);
      right[k] = kAnchor * mm(i) + (has_data ? w * data_mm : 0);
    }
    for (const Link& l : links_) add_link(l, link_weight(l, round), &entries, &right);
    matrix->setFromTriplets(entries.begin(), entries.end());
    return right;
  }

  void add_link(const Link& l, double w, std::vector<Eigen::Triplet<double>>* entries,
                Eigen::VectorXd* right) {
    const int a = unknown(l.a), b = unknown(l.b);
    if (a >= 0) entries->emplace_back(a, a, w);
    if (b >= 0) entries->emplace_back(b, b, w * l.ratio * l.ratio);
    if (a >= 0 && b >= 0) {
      entries->emplace_back(a, b, -w * l.ratio);
      entries->emplace_back(b, a, -w * l.ratio);
    } else if (a >= 0) {
      (*right)[a] += w * l.ratio * mm(l.b);
    } else {
      (*right)[b] += w * l.ratio * mm(l.a);
    }
  }

  const DepthMap& measured_;
  Image1& distance_;
  cv::Mat1i unknown_;       // number of each doubtful pixel, -1 for the others
  std::vector<int> place_;  // in the image, of each doubtful pixel
  std::vector<Link> links_;
};

}  // namespace

void relax_depth(const Camera& camera, const SurfaceNormals& normals, const DepthMap& measured,
                 int rounds, Image1* distance_mm) {
  Relaxation relaxation(measured, distance_mm);
  if (relaxation.size() == 0) return;
  relaxation.link_neighbours(camera, normals);
  relaxation.solve(kRobustRounds + rounds);
}

}  // namespace lamella::fit
