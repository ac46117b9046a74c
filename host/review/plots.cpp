#include "review/plots.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "model/dipole.h"

namespace lamella::review {

namespace {

constexpr float kPlotHeight = 110.f;
constexpr double kProfileMm = 8.0;
constexpr ImU32 kAxis = IM_COL32(90, 90, 94, 255), kLine = IM_COL32(225, 225, 220, 255);
constexpr std::array<ImU32, 3> kChannel{IM_COL32(235, 110, 95, 255), IM_COL32(120, 205, 120, 255),
                                        IM_COL32(110, 150, 240, 255)};

struct Frame {
  ImVec2 corner, size;
  ImVec2 at(double x, double y) const {  // both 0 to 1, y up
    return {corner.x + float(x) * size.x, corner.y + (1.f - float(y)) * size.y};
  }
};

Frame begin_plot(float height) {
  const Frame f{ImGui::GetCursorScreenPos(), {ImGui::GetContentRegionAvail().x, height}};
  ImGui::Dummy(f.size);
  ImGui::GetWindowDrawList()->AddRect(f.corner, f.at(1, 0), kAxis);
  return f;
}

void curve(const std::vector<ImVec2>& points, ImU32 colour) {
  ImGui::GetWindowDrawList()->AddPolyline(points.data(), int(points.size()), colour, 0, 1.6f);
}

}  // namespace

void plot_lobe(const v1::SpecularLobe& lobe) {
  if (lobe.theta_size() < 2 || lobe.p_size() != lobe.theta_size()) {
    ImGui::TextDisabled("no lobe");
    return;
  }
  ImGui::Text("specular lobe, Gaussian width %.3f rad", lobe.gaussian_m());
  const double top = 1.05 * *std::max_element(lobe.p().begin(), lobe.p().end());
  const double end = lobe.theta(lobe.theta_size() - 1);
  const Frame f = begin_plot(kPlotHeight);
  std::vector<ImVec2> points;
  for (int i = 0; i < lobe.theta_size(); ++i) {
    const double x = lobe.theta(i) / end, y = lobe.p(i) / top;
    points.push_back(f.at(x, y));
    if (lobe.p_stddev_size() != lobe.p_size()) continue;
    const double e = lobe.p_stddev(i) / top;
    ImGui::GetWindowDrawList()->AddLine(f.at(x, std::max(0.0, y - e)),
                                        f.at(x, std::min(1.0, y + e)), kAxis);
  }
  curve(points, kLine);
  ImGui::TextDisabled("angle of half vector and normal, 0 to %.0f\u00b0", end * 180 / M_PI);
}

void plot_profile(const v1::DeepScattering& deep) {
  if (deep.ld_mm_size() != 3) {
    ImGui::TextDisabled("no deep layer");
    return;
  }
  ImGui::Text("deep, mean free path %.2f %.2f %.2f mm", deep.ld_mm(0), deep.ld_mm(1),
              deep.ld_mm(2));
  const Frame f = begin_plot(kPlotHeight);
  for (int c = 0; c < 3; ++c) {
    const double alpha = deep.alpha_dot_size() == 3 ? deep.alpha_dot(c) : 0.9;
    std::vector<double> values;
    for (double r = 0.02; r < kProfileMm; r += 0.08) {
      values.push_back(r *
                       model::dipole_reflectance(model::Dipole<double>{alpha, deep.ld_mm(c)}, r));
    }
    const double top = 1.05 * *std::max_element(values.begin(), values.end());
    std::vector<ImVec2> points;
    for (size_t i = 0; i < values.size(); ++i) {
      points.push_back(f.at(double(i) / double(values.size() - 1), values[i] / top));
    }
    curve(points, kChannel[size_t(c)]);
  }
  ImGui::TextDisabled("r R(r) of the dipole, 0 to %.0f mm", kProfileMm);
}

void plot_timing(const v1::TimingEdges& timing) {
  std::map<std::string, int> row;
  double end_us = 1, worst_us = 0;
  for (const v1::TimedEdge& e : timing.edges()) {
    row.emplace(e.line(), 0);
    end_us = std::max({end_us, e.planned_us(), e.actual_us()});
    worst_us = std::max(worst_us, std::abs(e.actual_us() - e.planned_us()));
  }
  int rows = 0;
  for (auto& [line, index] : row) index = rows++;
  ImGui::Text("%d edges in %.0f ms, latest %.1f us from its plan", timing.edges_size(),
              end_us / 1000, worst_us);
  const float row_px = ImGui::GetTextLineHeight() * 1.3f;
  float names_px = 0;
  for (const auto& [line, index] : row) {
    names_px = std::max(names_px, ImGui::CalcTextSize(line.c_str()).x);
  }
  const Frame f = begin_plot(row_px * float(std::max(1, rows)));
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float left = f.corner.x + names_px + 12, width = f.corner.x + f.size.x - 4 - left;
  for (const v1::TimedEdge& e : timing.edges()) {
    const bool is_late = std::abs(e.actual_us() - e.planned_us()) > e.tolerance_us();
    const float x = left + width * float(e.actual_us() / end_us);
    const float y = f.corner.y + row_px * float(row[e.line()]);
    draw.AddLine({x, y + 0.15f * row_px}, {x, y + 0.85f * row_px}, is_late ? kChannel[0] : kLine);
  }
  for (const auto& [line, index] : row) {
    draw.AddText({f.corner.x + 4, f.corner.y + row_px * float(index) + 0.15f * row_px}, kChannel[2],
                 line.c_str());
  }
  ImGui::TextDisabled("0 to %.0f ms; red: later than its tolerance", end_us / 1000);
}

}  // namespace lamella::review
