// Which figures are live, and what begins each: a function of its panel and its name.

import { approach } from "./approach.js";
import { beats } from "./beats.js";
import { chance } from "./chance.js";
import { comparisons } from "./comparisons.js";
import { doors } from "./doors.js";
import { histogramsOf } from "./histograms.js";
import { interaction } from "./interaction.js";
import { kernels } from "./kernels.js";
import { rootLocus } from "./loop.js";
import { newton } from "./newton.js";
import { resampling } from "./resampling.js";
import { successCurves } from "./success.js";
import { blur, surfaces } from "./surfaces.js";
import { wall } from "./wall.js";

export const LIVE = {
  "cordoba2014.complexity": comparisons,
  "nummiaro2003.fig3": doors,
  "own.approach": approach,
  "own.beats": beats,
  "own.chance": chance,
  "own.interaction": interaction,
  "own.newton": newton,
  "own.resampling": resampling,
  "own.root_locus": rootLocus,
  "own.success": successCurves,
  "teuliere2009.fig1": histogramsOf,
  "teuliere2009.fig2": kernels,
  "teuliere2009.fig3": surfaces,
  "teuliere2009.fig4": blur,
  "teuliere2009.fig6": wall,
};
