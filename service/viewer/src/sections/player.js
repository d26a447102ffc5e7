// The time that is shown, and what moves it: play, pause, scrub, speed, steps of one sample.

import { byId, make } from "../dom.js";
import { decimals, duration, unitFor } from "../numbers.js";

const FACTORS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 50];
const USUAL = FACTORS.indexOf(1);
const TURN_S = 4; // a turn of the body takes so long on the screen, at speed 1
const LEAST_S = 12; // and the whole span at least so long: a slow or resting body would else be over at once
const MARKS = 200;

export class Player {
  constructor(onTime) {
    this.onTime = onTime;
    this.slider = byId("time");
    this.button = byId("play");
    this.speed = byId("speed");
    this.playing = false;
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.slider.addEventListener("keydown", (event) => this.key(event));
    this.button.addEventListener("click", () => this.toggle());
    byId("back").addEventListener("click", () => this.step(-1));
    byId("forth").addEventListener("click", () => this.step(1));
    this.#paintButton();
  }

  show(course) {
    this.pause();
    this.course = course;
    this.unit = unitFor(Math.max(Math.abs(course.start), Math.abs(course.stop)));
    [this.slider.min, this.slider.max] = [course.start, course.stop];
    const turns = (course.meanRate * course.span) / (2 * Math.PI);
    this.usual = course.span / Math.max(LEAST_S, turns * TURN_S);
    if (!course.connected) this.usual = course.span / (10 * LEAST_S);
    const chosen = this.speed.selectedIndex < 0 ? USUAL : this.speed.selectedIndex;
    this.speed.replaceChildren(...FACTORS.map((factor) => make("option", { value: factor }, this.#pace(factor))));
    this.speed.selectedIndex = chosen;
    const fits = course.events.slice(0, MARKS).map((event) => this.#mark(event));
    byId("marks").replaceChildren(...fits);
    this.seek(course.start);
  }

  /** Windows as stretches of the slider: [{start_s, stop_s}]. */
  mark(windows) {
    const { start, span } = this.course;
    const part = (t) => (100 * (t - start)) / (span || 1);
    const stretches = windows.slice(0, MARKS).map(({ start_s: from, stop_s: to }) => {
      const stretch = make("span", {});
      stretch.style.left = `${part(from).toFixed(3)}%`;
      stretch.style.width = `${Math.max(0.15, part(to) - part(from)).toFixed(3)}%`;
      return stretch;
    });
    byId("window-marks").replaceChildren(...stretches);
  }

  seek(time) {
    const { course } = this;
    if (!course) return;
    this.time = Math.min(course.stop, Math.max(course.start, time));
    this.slider.value = this.time;
    const shown = this.text(this.time);
    const whole = this.text(course.stop);
    byId("clock").textContent = `${shown} / ${whole}`;
    this.slider.setAttribute("aria-valuetext", `${shown} of ${whole}`);
    this.onTime(this.time);
  }

  text(time) {
    const digits = decimals(this.course.span, this.unit);
    return `${(time / this.unit.seconds).toFixed(digits).replace("-", "−")} ${this.unit.name}`;
  }

  /** So many samples on; from between two, to the nearer ones first. */
  step(count) {
    if (!this.course) return;
    this.pause();
    const here = this.course.index(this.time);
    const between = this.time > this.course.t[here];
    const wanted = count < 0 && between ? here + count + 1 : here + count;
    this.seek(this.course.t[Math.max(0, Math.min(this.course.length - 1, wanted))]);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (!this.course || !this.course.span) return;
    if (this.time >= this.course.stop) this.seek(this.course.start);
    this.playing = true;
    this.#paintButton();
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const passed = Math.min(0.25, Math.max(0, (now - last) / 1000)); // no leap after a page was hidden
      last = now;
      this.seek(this.time + passed * this.usual * Number(this.speed.value));
      if (this.time >= this.course.stop) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    this.#paintButton();
  }

  faster(steps) {
    const wanted = this.speed.selectedIndex + steps;
    this.speed.selectedIndex = Math.max(0, Math.min(FACTORS.length - 1, wanted));
  }

  /** Whether the key was one of ours. */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const by = event.shiftKey ? 10 : 1;
    const keys = {
      ArrowLeft: () => this.step(-by),
      ArrowRight: () => this.step(by),
      Home: () => this.#end("start"),
      End: () => this.#end("stop"),
      " ": () => this.toggle(),
      "-": () => this.faster(-1),
      "+": () => this.faster(1),
      "=": () => this.faster(1),
    };
    const act = keys[event.key];
    if (!act) return false;
    event.preventDefault();
    event.stopPropagation();
    act();
    return true;
  }

  #end(which) {
    if (!this.course) return;
    this.pause();
    this.seek(this.course[which]);
  }

  #pace(factor) {
    return `1 s shows ${duration(factor * this.usual, 2)}`;
  }

  #mark(event) {
    const part = (event.elapsed_s - this.course.start) / (this.course.span || 1);
    const mark = make("span", { title: event.text });
    mark.style.left = `${(100 * part).toFixed(3)}%`;
    return mark;
  }

  #paintButton() {
    this.button.classList.toggle("playing", this.playing);
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }
}
