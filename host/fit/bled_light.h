// Where a pixel is not as bright as the slope that was measured there would be in the projector's
// light: it is lit another way.
#pragma once

#include "fit/depth_map.h"

namespace lamella::fit {

// How bright the projector makes each pixel beside how bright the LEDs do, 1 at the median of
// `subject`; the skin's colour is in both. `front_lit` and `led_lit`: radiance, depolarized. 1
// where the LEDs give nothing.
Image1 projector_share(const Image3& front_lit, const Image3& led_lit, const Mask& subject);

// Light that bled into a shadow under the skin, or bounced there from face to face, has the phase
// of where it came from: the surface that its columns tell lies along the sheets of light, and
// faces away from a projector that makes it bright. What faces away so is forgotten, with what
// is doubtful beside it; what is doubtful elsewhere, brighter or darker than its slope would be,
// gets a greater bias. Only where `projector_share` is small: elsewhere such light is too little to
// matter.
void doubt_bled_light(const Camera& camera, const Camera& projector, const Image1& projector_share,
                      DepthMap* depth);

}  // namespace lamella::fit
