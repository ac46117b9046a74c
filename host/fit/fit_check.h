// What speaks against a fit without a truth to hold it against. Photographs that got each other's
// names, exposures that are not what the manifest says, a calibration of another day: they all fit,
// smoothly and to figures that are far off. But most of what is fitted is told twice.
#pragma once

#include "fit/black_check.h"
#include "fit/dot_check.h"
#include "fit/layers.h"
#include "fit/rerender.h"

namespace lamella::fit {

// Throws Error where hardly any labelled pixel was triangulated. Of a mesh, mesh_depth() does.
void require_surface(const Burst& burst, const Geometry& geometry);

// Each of these puts its figures among the report's checks, and a line that is poor to `fit->check`
// where one is beyond what good sessions show, of any skin and of four times the usual noise.

// Share of the labelled pixels for which the maps have a position. Not of a mesh, which has a line
// of its own.
void judge_positions(const Burst& burst, LayeredFit* fit);

// How large what was measured is: a rig stated in centimetres is as sharp as one in millimetres.
void judge_size(const Burst& burst, const Geometry& geometry, LayeredFit* fit);

// The left camera's positions against the right one's.
void judge_right(const Geometry& geometry, LayeredFit* fit);

// The gradients against GRADIENT_FULL, all crossed: c is what FULL has beyond its crossed light.
void judge_full(const LedGains& gains, LayeredFit* fit);

// Normals against positions.
void judge_surface(const Burst& burst, const Geometry& geometry, const Normals& normals,
                   LayeredFit* fit);

// The subject's mean normal against +Z, which the unit of radiance is tied to.
void judge_facing(const Burst& burst, const Normals& normals, LayeredFit* fit);

// BLACK, without which dots are not as dark as they are, against STRIPES.
void judge_black(const BlackLevels& black, LayeredFit* fit);

// STRIPES and DOTS against their patterns on the surface, where the camera resolves these.
void judge_stripes(const Session& session, const Separation& separation, LayeredFit* fit);
void judge_dots(const Session& session, const DotsSeen& seen, LayeredFit* fit);

// FRONT, which the projector lights, against the albedo that the LEDs tell.
void judge_rerender(const RerenderResiduals& residuals, LayeredFit* fit);

// The same of what is reflected: c is of the LEDs' light alone, FRONT's is the projector's.
void judge_parallel(const RerenderResiduals& residuals, LayeredFit* fit);

// Where skin would reflect more light than it gets its albedo is 1.
void judge_albedo(LayeredFit* fit);

}  // namespace lamella::fit
