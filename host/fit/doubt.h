// How far the figures of one layer on one region are to be believed, besides their deviations.
#pragma once

namespace lamella::fit {

enum class Doubt {
  kNone,       // fitted, or seen not to be there
  kAtBound,    // a figure stands where the fit lets it go no further
  kOff,        // what was measured is far from anything that the layer's model can be
  kNotJudged,  // too little of the layer was seen to tell it from none, or from another region's
};

}  // namespace lamella::fit
