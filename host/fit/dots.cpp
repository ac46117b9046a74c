#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/box_sums.h"
#include "fit/channel_fit.h"
#include "fit/one_layer.h"
#include "fit/order_statistics.h"
#include "fit/scattering.h"
#include "model/diffuse_reflectance.h"

namespace lamella::fit {

namespace {

// 1/sigma_t' of dermis in red, green and blue (about 610, 540 and 465 nm): 2 to 4 per mm in the
// literature, falling with the wavelength to the power of 1.4 (S. L. Jacques, "Optical properties
// of biological tissues: a review", 2013).
constexpr std::array<double, 3> kDermisTransport_mm{0.38, 0.32, 0.26};
constexpr double kBlend_mm = 3;             // l_d goes from one region's to the next's over this
constexpr double kSpreadAtHalfTrust = 0.1;  // of l_d, relative
constexpr float kHighestReflectance = 0.97f;
// Of the tail's logarithm against its dipole's. Beyond it half of the l_d of simulated skins are a
// fifth and more off before regions lean on each other, up to it one in fifty.
constexpr double kFurthestTail = 0.35;

// Medians over a region.
std::array<ShallowLight, 3> shallow_light(const Burst& burst, const Separation& separation,
                                          int label) {
  std::array<ShallowLight, 3> light{};
  for (int c = 0; c < 3; ++c) {
    std::vector<float> shallow, deep;
    for (int y = 0; y < burst.regions.rows; y += 2) {
      for (int x = 0; x < burst.regions.cols; x += 2) {
        if (burst.regions(y, x) != label || !is_finite(separation.deep_albedo(y, x))) continue;
        shallow.push_back(separation.shallow_albedo(y, x)[c]);
        deep.push_back(separation.deep_albedo(y, x)[c]);
      }
    }
    const double s = median_of(&shallow), d = median_of(&deep);
    light[size_t(c)] = {s + d > 0 ? s / (s + d) : 0.5, s};
  }
  return light;
}

// "blue's " and what is said of it, after what was said before.
void add_why(const std::string& of_channel, size_t channel, std::string* why) {
  *why += (why->empty() ? "" : "; ") + std::string(kChannelNames[channel]) + "'s " + of_channel;
}

// "blue's alpha_dot, 0.02, is the fit's own bound".
void add_bound(const std::string& at_bound, size_t channel, std::string* why, Doubt* doubt) {
  if (at_bound.empty()) return;
  add_why(at_bound + ", is the fit's own bound", channel, why);
  *doubt = Doubt::kAtBound;
}

// "blue's kernel is 67 % off any dipole's: it hardly tells l_d".
void add_misfit(double rms, size_t channel, RegionScattering* region) {
  if (rms <= kFurthestTail) return;
  add_why(fmt::format("kernel is {:.0f} % off any dipole's: it hardly tells l_d", 100 * rms),
          channel, &region->deep_why);
  region->deep_doubt = Doubt::kOff;
}

void put_channel(const DeepProfile& deep, const LayeredProfile& layers, size_t c,
                 RegionScattering* region) {
  region->ld_mm[c] = deep.ld_mm;
  region->ld_mm_stddev[c] = deep.ld_mm_stddev;
  region->deep_rms[c] = layers.deep_rms;
  region->alpha_dot[c] = layers.alpha_dot;
  region->alpha_dot_stddev[c] = layers.alpha_dot_stddev;
  region->shallow_alpha[c] = layers.shallow_alpha;
  region->shallow_alpha_stddev[c] = layers.shallow_alpha_stddev;
  region->shallow_ld_mm[c] = layers.shallow_ld_mm;
  region->shallow_ld_mm_stddev[c] = layers.shallow_ld_mm_stddev;
  region->shallow_rms[c] = layers.shallow_rms;
  add_bound(layers.deep_at_bound, c, &region->deep_why, &region->deep_doubt);
  add_misfit(deep.rms, c, region);
  if (region->shallow_fitted) {
    add_bound(layers.shallow_at_bound, c, &region->shallow_why, &region->shallow_doubt);
  }
  if (!layers.shallow_fitted) {
    region->shallow_fitted = false;
    region->shallow_why = layers.shallow_why;
    region->shallow_doubt = Doubt::kNone;
  }
}

// One dipole for all of it: the deep layer is that, and there is no other.
void leave_one_layer(const std::string& why, RegionScattering* region) {
  for (size_t c = 0; c < 3; ++c) {
    const SingleLayer& one = region->single_layer[c];
    region->ld_mm[c] = one.ld_mm;
    region->ld_mm_stddev[c] = one.ld_mm_stddev;
    region->alpha_dot[c] = one.alpha;
    region->alpha_dot_stddev[c] = one.alpha_stddev;
    region->deep_rms[c] = one.rms;
    region->shallow_ld_mm[c] = 0;
  }
  region->deep_why.clear();
  region->deep_doubt = region->shallow_doubt = Doubt::kNone;
  region->shallow_fitted = false;
  region->shallow_why = why;
}

void choose_layers(LayerUse use, const std::array<LayerContest, 3>& channels,
                   const std::array<ShallowLight, 3>& shallow, RegionScattering* region) {
  for (size_t c = 0; c < 3; ++c) region->single_layer[c] = channels[c].single;
  if (use == LayerUse::kSingle) {
    leave_one_layer("one layer was asked for (--layers single)", region);
  } else if (region->shallow_why.empty()) {
    const double share = (shallow[0].share + shallow[1].share + shallow[2].share) / 3;
    region->shallow_why = reason_to_keep(channels, share);
  }
}

// One layer has all the light.
void fold_shallow_light(Separation* separation) {
  parallel_for(separation->shallow_albedo.rows, [&](int y) {
    for (int x = 0; x < separation->shallow_albedo.cols; ++x) {
      Vec3& shallow = separation->shallow_albedo(y, x);
      if (!is_finite(shallow)) continue;
      separation->deep_albedo(y, x) += shallow;
      shallow = Vec3(0, 0, 0);
    }
  });
  separation->deep_confidence = separation->confidence.clone();
}

// How many pixels of each other region border on region `label`.
std::vector<double> border_lengths(const Labels& regions, int label, size_t count) {
  std::vector<double> length(count + 1, 0.0);
  Mask own = regions == label, grown;
  cv::dilate(own, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {25, 25}));
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      if (grown(y, x) && regions(y, x) != label) length[regions(y, x)] += 1;
    }
  }
  length[0] = 0;
  return length;
}

// A region without a dot of its own takes the mean of those that border on it, or of all.
void borrow(const Labels& labels, size_t index, std::vector<RegionScattering>* regions) {
  std::vector<double> weight = border_lengths(labels, int(index) + 1, regions->size());
  const auto fitted = [&](size_t i) { return (*regions)[i].dots > 0; };
  double sum = 0;
  for (size_t i = 0; i < regions->size(); ++i) sum += fitted(i) ? weight[i + 1] : 0;
  const auto all = std::count_if(regions->begin(), regions->end(),
                                 [](const RegionScattering& r) { return r.dots > 0; });
  RegionScattering taken;
  taken.deep_why = all > 0 ? "no dot of the pattern lies on it: its neighbours' values"
                           : "no dot of the pattern could be measured on any region";
  taken.shallow_why = taken.deep_why;
  taken.deep_doubt = taken.shallow_doubt = Doubt::kNotJudged;
  if (all > 0) taken.thickness_mm = 0;
  for (size_t i = 0; i < regions->size(); ++i) {
    if (!fitted(i)) continue;
    const RegionScattering& from = (*regions)[i];
    const double share = sum > 0 ? weight[i + 1] / sum : 1 / double(all);
    taken.thickness_mm += share * from.thickness_mm;
    for (size_t c = 0; c < 3; ++c) {
      taken.ld_mm[c] += share * from.ld_mm[c];
      taken.ld_mm_stddev[c] += share * (from.ld_mm_stddev[c] + 0.2 * from.ld_mm[c]);
      taken.alpha_dot[c] += share * from.alpha_dot[c];
      taken.alpha_dot_stddev[c] += share * from.alpha_dot_stddev[c];
      taken.deep_rms[c] += share * from.deep_rms[c];
      taken.shallow_alpha[c] += share * from.shallow_alpha[c];
      taken.shallow_alpha_stddev[c] += share * from.shallow_alpha_stddev[c];
      taken.shallow_ld_mm[c] += share * from.shallow_ld_mm[c];
      taken.shallow_ld_mm_stddev[c] += share * from.shallow_ld_mm_stddev[c];
      taken.shallow_rms[c] += share * from.shallow_rms[c];
    }
  }
  (*regions)[index] = taken;
}

// 1 for a figure without deviation, 1/2 at the relative deviation above.
float trust_in_ld(const RegionScattering& region) {
  double relative = 0;
  for (size_t c = 0; c < 3; ++c) relative += region.ld_mm_stddev[c] / region.ld_mm[c] / 3;
  return float(1 / (1 + relative / kSpreadAtHalfTrust));
}

// Of every pixel l_d, and how far it is to be believed.
void blend_ld(const Burst& burst, Scattering* scattering) {
  const cv::Size size = burst.regions.size();
  std::vector<cv::Vec4f> of_label{cv::Vec4f::all(0)};
  for (const RegionScattering& region : scattering->regions) {
    const Vec3 ld(float(region.ld_mm[0]), float(region.ld_mm[1]), float(region.ld_mm[2]));
    of_label.push_back(ld[0] > 0 ? cv::Vec4f(ld[0], ld[1], ld[2], trust_in_ld(region))
                                 : cv::Vec4f::all(0));
  }
  cv::Mat_<cv::Vec4f> sum(size);
  Image1 weight(size);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      sum(y, x) = of_label[burst.regions(y, x)];
      weight(y, x) = sum(y, x)[0] > 0 ? 1.f : 0.f;
    }
  });
  const Camera& camera = burst.session->left;
  const double px_per_mm = 1 / camera.pixel_mm();
  const int width = std::max(1, int(kBlend_mm * px_per_mm)) | 1;
  sum = box_sums(sum, width);
  weight = box_sums(weight, width);
  scattering->deep_ld_mm = filled<Image3>(size, Vec3(kNaN, kNaN, kNaN));
  scattering->ld_confidence = filled<Image1>(size, 0.f);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x) || !(weight(y, x) > 0)) continue;
      const cv::Vec4f mean = sum(y, x) * (1 / weight(y, x));
      scattering->deep_ld_mm(y, x) = Vec3(mean[0], mean[1], mean[2]);
      scattering->ld_confidence(y, x) = mean[3];
    }
  });
}

Image3 alpha_map(const Image3& deep_albedo) {
  static const model::AlphaTable table;
  auto alpha = filled<Image3>(deep_albedo.size(), Vec3(kNaN, kNaN, kNaN));
  parallel_for(alpha.rows, [&](int y) {
    for (int x = 0; x < alpha.cols; ++x) {
      const Vec3& deep = deep_albedo(y, x);
      if (!is_finite(deep)) continue;
      for (int c = 0; c < 3; ++c) {
        alpha(y, x)[c] = table.alpha(std::min(deep[c], kHighestReflectance));
      }
    }
  });
  return alpha;
}

// What is known of a region, or nothing where it has no dots.
struct RegionData {
  const RegionEquations* dots = nullptr;
  std::array<KnownSkin, 3> known{};
  std::array<ChannelTails, 3> tails;
};

std::vector<RegionData> measure_regions(const Burst& burst, const Separation& separation,
                                        const std::vector<RegionEquations>& equations,
                                        const PatternBlur& blur) {
  std::vector<RegionData> regions(equations.size());
  parallel_for(int(regions.size()), [&](int i) {
    RegionData& region = regions[size_t(i)];
    const RegionEquations& own = equations[size_t(i)];
    if (own[0].empty() || own[1].empty() || own[2].empty()) return;
    region.dots = &own;
    const std::array<ShallowLight, 3> shallow = shallow_light(burst, separation, i + 1);
    parallel_for(3, [&](int channel) {
      const auto c = size_t(channel);
      const double reflectance = shallow[c].share > 0 ? shallow[c].albedo / shallow[c].share : 0;
      region.known[c] = {{kDermisTransport_mm[c], reflectance}, shallow[c]};
      region.tails[c] = fit_tails(own[c], region.known[c].prior, blur);
    });
  });
  return regions;
}

void fit_region(LayerUse use, const RegionData& data, const PatternBlur& blur,
                RegionScattering* region) {
  region->dots = int((*data.dots)[1].size());
  region->deep_fitted = region->shallow_fitted = true;
  std::array<SlabProfiles, 3> slabs;
  std::array<LayerContest, 3> contests;
  std::array<ShallowLight, 3> shallow;
  parallel_for(3, [&](int channel) {
    const auto c = size_t(channel);
    const ChannelTails& tails = data.tails[c];
    shallow[c] = data.known[c].shallow;
    slabs[c] = fit_layered_profiles(tails.kernels.all, tails.all, data.known[c]);
    contests[c] = contest_of((*data.dots)[c], tails.all.ld_mm, shallow[c].share, blur);
  });
  std::array<LayeredProfile, 3> layers = on_best_slab(slabs);
  region->thickness_mm = layers[0].thickness_mm;
  parallel_for(3, [&](int channel) {
    const auto c = size_t(channel);
    widen_layers(data.tails[c], data.known[c], &layers[c]);
  });
  for (size_t c = 0; c < 3; ++c) put_channel(data.tails[c].all, layers[c], c, region);
  choose_layers(use, contests, shallow, region);
}

// What colour found regions by, and a shape that the fringes did not measure, move it by more than
// its deviation says.
OneLayerVerdict verdict_of(const Burst& burst, const std::vector<RegionData>& regions) {
  if (burst.mesh || !burst.has_given_regions) {
    return {.why = "not judged, as that takes given regions and positions by the fringes"};
  }
  std::vector<OneLayerRegion> known;
  for (const RegionData& region : regions) {
    if (!region.dots) continue;
    OneLayerRegion one{*region.dots, {}};
    for (size_t c = 0; c < 3; ++c) one.reflectance[c] = region.known[c].prior.reflectance;
    known.push_back(std::move(one));
  }
  const Session& session = *burst.session;
  return judge_one_layer(known, footprint_mm(session.left, session.projector));
}

// A slab then stands for what a dipole is wrong by where light enters, and for no layer.
void tell_one_layer(const OneLayerVerdict& verdict, std::vector<RegionScattering>* regions) {
  for (RegionScattering& region : *regions) {
    if (!verdict.is_one || !region.shallow_fitted) continue;
    region.shallow_why +=
        "; but skin is found to be one homogeneous layer, and this one stands "
        "for what a dipole does not foresee of it";
  }
}

// Those that have no dots stay empty.
void fit_regions(const Burst& burst, LayerUse use, const std::vector<RegionEquations>& equations,
                 const Separation& separation, Scattering* scattering) {
  std::vector<RegionScattering>* out = &scattering->regions;
  const PatternBlur blur = pattern_blur(*burst.session, equations);
  std::vector<RegionData> regions = measure_regions(burst, separation, equations, blur);
  for (size_t c = 0; c < 3; ++c) {
    std::vector<ChannelTails*> tails;
    for (RegionData& region : regions) {
      if (region.dots) tails.push_back(&region.tails[c]);
    }
    lean_on_each_other(tails);
  }
  parallel_for(int(regions.size()), [&](int i) {
    if (regions[size_t(i)].dots) fit_region(use, regions[size_t(i)], blur, &(*out)[size_t(i)]);
  });
  if (use != LayerUse::kAuto) return;
  scattering->one_layer = verdict_of(burst, regions);
  tell_one_layer(scattering->one_layer, out);
}

}  // namespace

Scattering fit_scattering(const Burst& burst, const Geometry& geometry, const Normals& normals,
                          LayerUse use, Separation* separation) {
  Scattering scattering;
  scattering.regions.resize(burst.region_names.size() - 1);
  const std::vector<Dot> dots = measure_dots(burst, geometry, normals);
  std::vector<RegionEquations> equations;
  for (size_t i = 0; i < scattering.regions.size(); ++i) {
    equations.push_back(equations_of_region(dots, int(i) + 1));
  }
  fit_regions(burst, use, equations, *separation, &scattering);
  const std::vector<RegionScattering> measured = scattering.regions;
  for (size_t i = 0; i < measured.size(); ++i) {
    if (measured[i].dots == 0) borrow(burst.regions, i, &scattering.regions);
  }
  blend_ld(burst, &scattering);
  if (use == LayerUse::kSingle) fold_shallow_light(separation);
  scattering.deep_alpha = alpha_map(separation->deep_albedo);
  return scattering;
}

}  // namespace lamella::fit
