// Least squares from normal equations with some unknowns bounded below by zero.
#pragma once

#include <opencv2/core.hpp>

namespace lamella::fit {

// Minimises x' M x - 2 b' x with x[i] >= 0 for i < bounded (Lawson and Hanson's active set).
// `m`: n x n, symmetric, positive semidefinite; `b`: n x 1, both double. Returns n x 1.
cv::Mat1d solve_non_negative(const cv::Mat1d& m, const cv::Mat1d& b, int bounded);

}  // namespace lamella::fit
