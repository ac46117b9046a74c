// From what the steps found to what is written: maps and layers.json.
#pragma once

#include "fit/layers.h"
#include "fit/rerender.h"

namespace lamella::fit {

void start_report(const Burst& burst, LayeredFit* fit);
void report_regions(const Burst& burst, LayeredFit* fit);
void report_geometry(const Burst& burst, const Geometry& geometry, LayeredFit* fit);
void report_normals(const Normals& normals, LayeredFit* fit);
void report_specular(const SpecularFit& specular, LayeredFit* fit);
void report_separation(const Separation& separation, LayeredFit* fit);
void report_scattering(const Scattering& scattering, LayeredFit* fit);
void report_albedo(const Albedo& albedo, LayeredFit* fit);
void report_rerender(const RerenderResiduals& residuals, LayeredFit* fit);

// No confidence in what is not known: last, of all maps.
void settle_confidence(LayerMaps* maps);

}  // namespace lamella::fit
