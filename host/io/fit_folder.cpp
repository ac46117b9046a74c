#include "io/fit_folder.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "io/map_values.h"

namespace lamella {

namespace {

using List = google::protobuf::RepeatedField<double>;

constexpr const char* kFitAgain = "run fit again";
constexpr const char* kFitToItsEnd = "run fit to its end";

void require_each(const List& values, const std::string& at, bool (*right)(double),
                  const std::string& expected) {
  for (double v : values) {
    if (!right(v)) throw_bad_input(at, "a number that is not " + expected, kFitAgain);
  }
}

bool is_finite_number(double v) { return std::isfinite(v); }
bool is_positive(double v) { return std::isfinite(v) && v > 0; }
bool is_not_negative(double v) { return std::isfinite(v) && v >= 0; }
bool is_share(double v) { return v >= 0 && v <= 1; }

// One figure per channel. `needed`: its layer was fitted, so it must be there.
void require_rgb(const List& values, bool needed, const std::string& at, bool (*right)(double),
                 const std::string& expected) {
  if (values.empty() && !needed) return;
  if (values.empty()) throw_bad_input(at, "missing", kFitAgain);
  if (values.size() != 3) throw_bad_input(at, "expected three numbers", kFitAgain);
  require_each(values, at, right, expected);
}

void require_lobe(const v1::SpecularLobe& lobe, bool needed, const std::string& at) {
  if (lobe.has_gaussian_m() && !is_positive(lobe.gaussian_m())) {
    throw_bad_input(at + ".gaussian_m", "not a positive number", kFitAgain);
  }
  if (lobe.theta().empty() && lobe.p().empty() && (lobe.has_gaussian_m() || !needed)) return;
  if (lobe.theta_size() < 2) throw_bad_input(at + ".theta", "fewer than two angles", kFitAgain);
  if (lobe.p_size() != lobe.theta_size()) {
    throw_bad_input(
        at + ".p",
        std::to_string(lobe.p_size()) + " numbers, theta has " + std::to_string(lobe.theta_size()),
        kFitAgain);
  }
  require_each(lobe.theta(), at + ".theta", is_not_negative, "an angle of 0 or more");
  require_each(lobe.p(), at + ".p", is_not_negative, "0 or more");
  if (!std::is_sorted(lobe.theta().begin(), lobe.theta().end(), std::less_equal<double>())) {
    throw_bad_input(at + ".theta", "angles that do not increase", kFitAgain);
  }
  if (*std::max_element(lobe.p().begin(), lobe.p().end()) <= 0) {
    throw_bad_input(at + ".p", "0 everywhere", kFitAgain);
  }
}

// What layers.json says of one layer of one region.
struct Told {
  const char* layer;
  bool fitted;  // by `layers.X`
  bool there;   // its message
};

// A layer that is not there was dropped, and the region says why.
void require_told(const v1::Region& region, const Told& told, const std::string& at) {
  if (told.there) return;
  const std::string field = at + "." + told.layer;
  if (!region.has_layers()) {
    throw_bad_input(field, "missing, and no layers.why says why", kFitToItsEnd);
  }
  if (told.fitted) {
    throw_bad_input(field, std::string("missing, though layers.") + told.layer + " is true",
                    kFitAgain);
  }
  const auto why = region.layers().why().find(told.layer);
  if (why == region.layers().why().end() || why->second.empty()) {
    throw_bad_input(field,
                    std::string("missing, and layers.why.") + told.layer + " gives no reason",
                    kFitToItsEnd);
  }
}

void require_region(const v1::Region& r, const std::string& at) {
  const v1::LayerChoice& fitted = r.layers();
  const Told tolds[] = {{"specular", fitted.specular(), r.has_specular()},
                        {"single", fitted.single(), r.has_single()},
                        {"shallow", fitted.shallow(), r.has_shallow()},
                        {"deep", fitted.deep(), r.has_deep()}};
  for (const Told& told : tolds) require_told(r, told, at);
  require_lobe(r.specular(), fitted.specular(), at + ".specular");
  require_rgb(r.single().amplitude(), fitted.single(), at + ".single.amplitude", is_finite_number,
              "finite");
  const std::string deep = at + ".deep", shallow = at + ".shallow";
  require_rgb(r.deep().ld_mm(), fitted.deep() || !r.has_layers(), deep + ".ld_mm", is_positive,
              "a positive length");
  require_rgb(r.deep().alpha_dot(), fitted.deep(), deep + ".alpha_dot", is_share, "from 0 to 1");
  require_rgb(r.shallow().ld_mm(), fitted.shallow(), shallow + ".ld_mm", is_not_negative,
              "0 or more");
  require_rgb(r.shallow().alpha(), fitted.shallow(), shallow + ".alpha", is_share, "from 0 to 1");
  if (r.shallow().has_thickness_mm() && !is_positive(r.shallow().thickness_mm())) {
    throw_bad_input(shallow + ".thickness_mm", "not a positive length", kFitAgain);
  }
}

void require_layers(const v1::Layers& layers, const std::string& file) {
  std::set<std::string> names;
  for (int i = 0; i < layers.regions_size(); ++i) {
    const std::string at = file + ": regions[" + std::to_string(i) + "]";
    const std::string& name = layers.regions(i).name();
    if (name.empty()) throw_bad_input(at + ".name", "missing", kFitAgain);
    if (!names.insert(name).second)
      throw_bad_input(at + ".name", "\"" + name + "\" comes twice", "fit again");
    require_region(layers.regions(i), at);
  }
  require_rgb(
      layers.single().g(), false, file + ": single.g", [](double g) { return g > -1 && g < 1; },
      "between -1 and 1");
  if (layers.has_ior() && !(layers.ior() >= 1 && layers.ior() < 10)) {
    throw_bad_input(file + ": ior", "not an index of refraction", kFitAgain);
  }
}

// Every label has its region, and some pixel has one.
void require_labels(const Labels& labels, int regions, const std::string& file) {
  double largest = 0;
  cv::minMaxLoc(labels, nullptr, &largest);
  if (largest == 0) throw_bad_input(file, "no pixel is labelled", kFitAgain);
  if (largest > regions) {
    throw_bad_input(file,
                    "label " + std::to_string(int(largest)) + ", but layers.json has " +
                        std::to_string(regions) + " regions",
                    kFitAgain);
  }
}

template <class Value>
bool is_known_somewhere(const cv::Mat_<Value>& map, const Labels& labels) {
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      if (labels(y, x) && is_finite(map(y, x))) return true;
    }
  }
  return false;
}

class MapCheck {
 public:
  MapCheck(const fs::path& folder, FitFolder* fit) : folder_(folder), fit_(fit) {}

  // `dropped`: it may say nothing; a map that does comes back empty.
  template <class Value>
  void require(const char* name, bool dropped, cv::Mat_<Value>* map) const {
    if (!map->empty() && is_known_somewhere(*map, fit_->maps.regions)) return;
    const std::string file = (folder_ / (std::string(name) + ".exr")).string();
    if (!dropped && map->empty()) throw_bad_input(file, "missing", kFitToItsEnd);
    if (!dropped) throw_bad_input(file, "no labelled pixel has a number", kFitAgain);
    map->release();
  }

  // Every region does without this layer.
  bool dropped(bool (v1::LayerChoice::*fitted)() const) const {
    const auto& regions = fit_->layers.regions();
    return std::all_of(regions.begin(), regions.end(), [&](const v1::Region& r) {
      return r.has_layers() && !(r.layers().*fitted)();
    });
  }

 private:
  const fs::path& folder_;
  FitFolder* fit_;
};

void require_maps(const fs::path& folder, FitFolder* fit) {
  LayerMaps& m = fit->maps;
  const MapCheck check(folder, fit);
  const bool no_deep = check.dropped(&v1::LayerChoice::deep);
  check.require("position", false, &m.position_mm);
  check.require("normal_specular", false, &m.normal_specular);
  for (Image3& normal : m.normal_diffuse) check.require("normal_diffuse", false, &normal);
  check.require("specular_intensity", check.dropped(&v1::LayerChoice::specular),
                &m.specular_intensity);
  check.require("single_albedo", check.dropped(&v1::LayerChoice::single), &m.single_albedo);
  check.require("shallow_albedo", false, &m.shallow_albedo);
  check.require("deep_albedo", false, &m.deep_albedo);
  check.require("deep_alpha", no_deep, &m.deep_alpha);
  check.require("deep_ld", no_deep, &m.deep_ld_mm);
  check.require("total_albedo", false, &m.total_albedo);
}

}  // namespace

FitFolder read_fit_folder(const fs::path& folder) {
  FitFolder fit;
  fit.maps = read_layer_maps(folder);
  const fs::path file = folder / "layers.json";
  fit.layers = read_layers(file);
  require_labels(fit.maps.regions, fit.layers.regions_size(), (folder / "regions.png").string());
  require_maps(folder, &fit);
  require_possible_values(folder, fit.maps);
  require_layers(fit.layers, file.string());
  return fit;
}

}  // namespace lamella
