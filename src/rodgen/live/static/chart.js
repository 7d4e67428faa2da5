// One picture by ECharts: axes whose ends and steps are given, and curves.

import { echarts } from "nicegui-echart";
import { above, base, multiples, short, written } from "./scales.js";
import { classes, theme } from "./theme.js";

export const MANY = 8; // series from which on they are coloured along a colour map
const EDGES = { left: 84, right: 28, top: 20, bottom: 38 };
const APART = [52, 26]; // pixels between numbers at the axes, at least

export function colours(spec) {
  const { series, along } = theme();
  const count = spec.kind === "time" ? spec.series.length : 1;
  return count > MANY ? classes(along, count) : series.slice(0, Math.max(count, 1));
}

const named = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);

// What the key says of a curve; its unit where the curves do not share that of the axis.
export const entry = ({ y }, { name, label, unit }) =>
  named({ label: label ?? name, unit: y.unit ? "" : unit });

export class Chart {
  #axes = [
    { step: 1, from: 0 },
    { step: 1, from: 0 },
  ];

  constructor(box, spec) {
    this.box = box;
    this.spec = spec;
    this.chart = echarts.init(box, null, { renderer: "canvas" });
    this.style();
  }

  // All that does not change from drawing to drawing.
  style() {
    this.chart.setOption(
      {
        animation: false,
        // Where the axes stand is known, whatever their numbers: pointers reckon with it.
        grid: { ...EDGES, outerBoundsMode: "none" },
        xAxis: this.#axis(0, this.spec.x, 24),
        yAxis: this.#axis(1, this.spec.y, 66),
        title: this.#bases(),
        series: this.#series(),
      },
      { notMerge: true },
    );
  }

  #axis(k, quantity, gap) {
    const { ink, faint, grid, axis } = theme();
    return {
      type: "value",
      name: named(quantity),
      nameLocation: "middle",
      nameGap: gap,
      nameTextStyle: { color: ink, fontSize: 11 },
      axisLine: { show: true, onZero: false, lineStyle: { color: axis } },
      axisTick: { show: false },
      axisLabel: {
        color: faint,
        fontSize: 11,
        hideOverlap: true,
        formatter: (value) => written(value - this.#axes[k].from, this.#axes[k].step),
      },
      splitLine: { lineStyle: { color: grid } },
    };
  }

  // What the numbers at the axes are counted from: at the end of x, above y.
  #bases() {
    const [x, y] = this.#axes.map(({ from }) => (from ? `from ${short(from, 15)}` : ""));
    const textStyle = { color: theme().ink, fontSize: 11, lineHeight: 12, fontWeight: "normal" };
    return [
      { text: x, right: 4, bottom: 3, padding: 0, textStyle },
      { text: y, left: 4, top: 2, padding: 0, textStyle },
    ];
  }

  #series() {
    const { spec } = this;
    const dots = spec.kind === "poincare";
    const shades = colours(spec);
    const plain = { animation: false, silent: true, emphasis: { disabled: true } };
    const count = spec.kind === "time" ? spec.series.length : 1;
    const curves = Array.from({ length: count }, (_, k) => ({
      ...plain,
      type: dots ? "scatter" : "line",
      symbol: dots ? "circle" : "none",
      symbolSize: 3,
      large: dots,
      itemStyle: { color: shades[k] },
      lineStyle: { color: shades[k], width: count > MANY ? 1 : 1.6 },
      data: [],
    }));
    // Where the curve of a phase plot is now.
    if (spec.kind === "phase") {
      curves.push({
        ...plain,
        type: "scatter",
        symbolSize: 8,
        itemStyle: { color: theme().present },
        data: [],
      });
    }
    return curves;
  }

  get size() {
    const wide = this.chart.getWidth() - EDGES.left - EDGES.right;
    return [Math.max(wide, 10), Math.max(this.chart.getHeight() - EDGES.top - EDGES.bottom, 10)];
  }

  // {x: [low, high], y: [low, high], curves}
  draw({ x, y, curves }) {
    const series = curves.map((data) => ({ data }));
    if (this.spec.kind === "phase") series.push({ data: curves[0].slice(-2) });
    this.shown = { x, y, curves };
    const axes = { xAxis: this.#ends(0, x), yAxis: this.#ends(1, y) };
    this.chart.setOption(
      { ...axes, title: this.#bases(), series },
      { silent: true },
    );
    this.chart.getZr().flush();
  }

  #ends(k, [low, high]) {
    const axis = this.#axes[k];
    axis.step = above((high - low) / Math.max(this.size[k] / APART[k], 2));
    const customValues = multiples(low, high, axis.step).map((count) => count * axis.step);
    axis.from = base(low, high, axis.step);
    return { min: low, max: high, axisTick: { customValues }, axisLabel: { customValues } };
  }

  // Pixels in the box to coordinates, and back.
  value(px, py) {
    const { x, y } = this.shown;
    const [wide, high] = this.size;
    return [
      x[0] + ((px - EDGES.left) / wide) * (x[1] - x[0]),
      y[1] - ((py - EDGES.top) / high) * (y[1] - y[0]),
    ];
  }

  place(vx, vy) {
    const { x, y } = this.shown;
    const [wide, high] = this.size;
    return [
      EDGES.left + ((vx - x[0]) / (x[1] - x[0])) * wide,
      EDGES.top + ((y[1] - vy) / (y[1] - y[0])) * high,
    ];
  }

  get edges() {
    return EDGES;
  }

  picture() {
    return this.chart.renderToCanvas({ pixelRatio: 2, backgroundColor: theme().background });
  }

  resize() {
    this.chart.resize();
  }

  dispose() {
    this.chart.dispose();
  }
}
