#include "fit/depth_relax.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/parallel.h"
#include "fit/order_statistics.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kDoubtfulSigmas = 2.f;  // of the median sigma
constexpr float kLeastFacing = 0.05f;   // more oblique, and a normal says nothing about depth
constexpr double kLinkSigmas = 1.5, kDataSigmas = 2.5;  // beyond, the other evidence is right
// First the wrong measurements are found. Links that are only given up in part tear a surface, so
// at the end each holds in full, or not at all, over a silhouette.
constexpr int kRobustRounds = 2;
constexpr double kFirstReach = 10;    // the first round believes links so many times further
constexpr double kFirstTrust = 0.05;  // and measurements so much less
constexpr double kAnchor = 1e-4;      // weight of the start, for islands without any evidence
// The surface is moved block by block, and within a block by sweeps, where pixels are finer than
// what the evidence tells: the equations of four times the unknowns take eight times as long.
constexpr float kBlock_mm = 0.25f;
constexpr int kLargestBlock_px = 4;
constexpr int kSweepsAPixel = 4;     // of a block's side
constexpr double kSweepShare = 0.7;  // of what a pixel's own equation asks for (Jacobi, damped)

using Matrix = Eigen::SparseMatrix<double>;

// Two neighbours, as places in the image, that should lie in one plane: a = ratio b.
struct Link {
  int a, b;
  double ratio, sigma_mm;
  double weight = 0;
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

// One connected piece of doubtful pixels: no link leads from one to another.
class Relaxation {
 public:
  // `place`: of each doubtful pixel of the piece in the image. `number`: its number in the piece,
  // -1 of a pixel that is not doubtful.
  Relaxation(const DepthMap& measured, const std::vector<int>& place, const cv::Mat1i& number,
             Image1* distance)
      : measured_(measured), place_(place), number_(number), distance_(*distance) {}

  long size() const { return long(place_.size()); }

  // Each pair once: of two doubtful neighbours the left or upper one names it.
  void link_neighbours(const Camera& camera, const SurfaceNormals& normals) {
    for (const int i : place_) {
      const cv::Point at(i % distance_.cols, i / distance_.cols);
      for (const cv::Point& step : {cv::Point(1, 0), cv::Point(0, 1)}) {
        link(camera, normals, at, at + step);
        if (!is_doubtful(at - step)) link(camera, normals, at - step, at);
      }
    }
  }

  void solve(int rounds) {
    number_blocks();
    Matrix matrix = pattern();
    Eigen::SimplicialLDLT<Matrix> solver;
    solver.analyzePattern(matrix);
    for (int round = 0; round < rounds; ++round) {
      weigh(round);
      Eigen::VectorXd right = set_equations(&matrix);
      solver.factorize(matrix);
      if (solver.info() != Eigen::Success) return;  // the last round's answer stays
      const Eigen::VectorXd move = solver.solve(right);
      for (size_t k = 0; k < place_.size(); ++k) mm(place_[k]) += float(move[block_of_[k]]);
      if (block_px_ > 1) sweep();
    }
  }

 private:
  float& mm(int place) { return distance_(place / distance_.cols, place % distance_.cols); }
  int number(int place) const { return number_(place / distance_.cols, place % distance_.cols); }
  bool is_inside(const cv::Point& p) const {
    return cv::Rect({0, 0}, distance_.size()).contains(p);
  }
  bool is_doubtful(const cv::Point& p) const { return is_inside(p) && number_(p) >= 0; }

  void link(const Camera& camera, const SurfaceNormals& normals, const cv::Point& a,
            const cv::Point& b) {
    if (!is_inside(a) || !is_inside(b)) return;
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

  void weigh(int round) {
    for (Link& l : links_) l.weight = link_weight(l, round);
    data_weight_.resize(place_.size());
    for (size_t k = 0; k < place_.size(); ++k) {
      const cv::Point at = point(place_[k]);
      const float data_mm = measured_.distance_mm(at);
      data_weight_[k] =
          std::isnan(data_mm) ? 0 : data_weight(place_[k], data_mm, measured_.sigma_mm(at), round);
    }
  }

  cv::Point point(int place) const { return {place % distance_.cols, place / distance_.cols}; }

  int block_key(int place) const {
    const cv::Point at = point(place) / block_px_;
    return at.y * (distance_.cols / block_px_ + 2) + at.x;
  }

  // Row by row; those that the piece reaches.
  void number_blocks() {
    key_.resize(place_.size());
    std::transform(place_.begin(), place_.end(), key_.begin(), [&](int i) { return block_key(i); });
    std::sort(key_.begin(), key_.end());
    key_.erase(std::unique(key_.begin(), key_.end()), key_.end());
    block_of_.resize(place_.size());
    for (size_t k = 0; k < place_.size(); ++k) block_of_[k] = *find_block(block_key(place_[k]));
  }

  std::optional<int> find_block(int key) const {
    const auto found = std::lower_bound(key_.begin(), key_.end(), key);
    if (found == key_.end() || *found != key) return std::nullopt;
    return int(found - key_.begin());
  }

  // The lower half of the normal equations, which is what is factorized: in the column of a block
  // its own entry and those of the blocks right of it and below.
  Matrix pattern() const {
    const long count = long(key_.size());
    const int below = distance_.cols / block_px_ + 2;
    Matrix matrix(count, count);
    matrix.reserve(3 * count);
    for (int k = 0; k < int(count); ++k) {
      matrix.startVec(k);
      matrix.insertBack(k, k) = 1;
      for (const int step : {1, below}) {
        const std::optional<int> other = find_block(key_[size_t(k)] + step);
        if (other) matrix.insertBack(*other, k) = 0;
      }
    }
    matrix.finalize();
    return matrix;
  }

  // What pulls at each pixel, and how stiffly it is held: minus the gradient of half the sum of
  // squares, and its own second derivative.
  struct Pull {
    Eigen::VectorXd force, stiffness;
  };
  Pull pull() {
    Pull p{Eigen::VectorXd::Zero(size()), Eigen::VectorXd::Constant(size(), kAnchor)};
    for (long k = 0; k < size(); ++k) {
      const double w = data_weight_[size_t(k)];
      if (w == 0) continue;
      const int i = place_[size_t(k)];
      p.force[k] += w * (double(measured_.distance_mm(point(i))) - double(mm(i)));
      p.stiffness[k] += w;
    }
    for (const Link& l : links_) {
      const double pull = l.weight * (double(mm(l.a)) - l.ratio * double(mm(l.b)));
      if (const int a = number(l.a); a >= 0) {
        p.force[a] -= pull;
        p.stiffness[a] += l.weight;
      }
      if (const int b = number(l.b); b >= 0) {
        p.force[b] += l.ratio * pull;
        p.stiffness[b] += l.weight * l.ratio * l.ratio;
      }
    }
    return p;
  }

  // For the move of each block, with this round's weights.
  Eigen::VectorXd set_equations(Matrix* matrix) {
    std::fill_n(matrix->valuePtr(), matrix->nonZeros(), 0.0);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(matrix->cols());
    const Pull p = pull();
    for (long k = 0; k < size(); ++k) {
      const int block = block_of_[size_t(k)];
      right[block] += p.force[k];
      entry(matrix, block, block) += p.stiffness[k];
    }
    for (const Link& l : links_) {
      const int a = number(l.a), b = number(l.b);
      if (a < 0 || b < 0) continue;
      const int block_a = block_of_[size_t(a)], block_b = block_of_[size_t(b)];
      entry(matrix, block_a, block_b) -= (block_a == block_b ? 2 : 1) * l.weight * l.ratio;
    }
    return right;
  }

  // A column has three entries at most.
  static double& entry(Matrix* matrix, int a, int b) {
    int at = matrix->outerIndexPtr()[std::min(a, b)];
    while (matrix->innerIndexPtr()[at] != std::max(a, b)) ++at;
    return matrix->valuePtr()[at];
  }

  // Takes out the steps that blocks have left.
  void sweep() {
    for (int i = 0; i < kSweepsAPixel * block_px_; ++i) {
      const Pull p = pull();
      for (long k = 0; k < size(); ++k) {
        mm(place_[size_t(k)]) += float(kSweepShare * p.force[k] / p.stiffness[k]);
      }
    }
  }

  const DepthMap& measured_;
  const std::vector<int>& place_;
  const cv::Mat1i& number_;
  Image1& distance_;
  const int block_px_ = std::clamp(int(kBlock_mm / measured_.px_mm), 1, kLargestBlock_px);
  std::vector<int> key_;       // of the piece's blocks, ascending
  std::vector<int> block_of_;  // of each pixel of the piece
  std::vector<Link> links_;
  std::vector<double> data_weight_;  // of each pixel of the piece
};

Mask doubtful_pixels(const DepthMap& measured, const Image1& distance) {
  const Mask wanted = distance == distance;
  Mask doubtful = wanted & ~(measured.distance_mm == measured.distance_mm);
  const int side = 2 * measured.penumbra_px + 1;
  cv::dilate(doubtful, doubtful, Mask::ones(side, side));
  doubtful |= measured.sigma_mm > kDoubtfulSigmas * median_sigma_mm(measured);
  return doubtful & wanted;
}

// The places of the pixels that are linked to one another, row by row in each piece. The largest
// piece is the first, the next the last and so on, as neighbours in a loop go to one processor.
std::vector<std::vector<int>> pieces_of(const Mask& mask) {
  cv::Mat1i piece;
  const int count = cv::connectedComponents(mask, piece, 4, CV_32S);
  std::vector<std::vector<int>> pieces(size_t(count) - 1);
  for (int i = 0; i < int(mask.total()); ++i) {
    if (mask.data[i]) pieces[size_t(piece(i / piece.cols, i % piece.cols)) - 1].push_back(i);
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<std::vector<int>> dealt(pieces.size());
  for (size_t i = 0; i < pieces.size(); ++i) {
    dealt[i % 2 ? pieces.size() - 1 - i / 2 : i / 2] = std::move(pieces[i]);
  }
  return dealt;
}

}  // namespace

void relax_depth(const Camera& camera, const SurfaceNormals& normals, const DepthMap& measured,
                 int rounds, Image1* distance_mm) {
  const std::vector<std::vector<int>> pieces = pieces_of(doubtful_pixels(measured, *distance_mm));
  cv::Mat1i number(distance_mm->size(), -1);
  for (const std::vector<int>& piece : pieces) {
    for (size_t k = 0; k < piece.size(); ++k) {
      number(piece[k] / number.cols, piece[k] % number.cols) = int(k);
    }
  }
  parallel_for(int(pieces.size()), [&](int i) {
    Relaxation relaxation(measured, pieces[size_t(i)], number, distance_mm);
    relaxation.link_neighbours(camera, normals);
    relaxation.solve(kRobustRounds + rounds);
  });
}

}  // namespace lamella::fit
