// The colour map PuOr, violet over near white to orange: for changes, with the middle at zero, and for the colour-blind too.
// Eleven classes of ColorBrewer by C. Brewer and M. Harrower, Pennsylvania State University 2002 (Apache-style licence). sRGB, six hexadecimal digits each.
import { colourMap } from "./map";

export const PUOR = colourMap("2d004b5427888073acb2abd2d8daebf7f7f7fee0b6fdb863e08214b358067f3b08");
