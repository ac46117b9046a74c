// Curves and charts in the current ImGui window.
#pragma once

#include "layers.pb.h"
#include "link.pb.h"

namespace lamella::review {

// p against the angle between the half vector and the normal, with its uncertainty.
void plot_lobe(const v1::SpecularLobe& lobe);

// Dipole of each channel against the distance on the skin, r R(r), each scaled to its largest.
void plot_profile(const v1::DeepScattering& deep);

// A row a line, a mark an edge: where it was planned, and where it was where that differs.
void plot_timing(const v1::TimingEdges& timing);

}  // namespace lamella::review
