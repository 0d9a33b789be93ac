// What a mark tells, the switches of the legend, menus of pictures, and sorted tables. The page reads the same without.
(function () {
  "use strict";
  var all = function (selector, within) { return Array.prototype.slice.call((within || document).querySelectorAll(selector)); };
  var element = function (name, text) { var made = document.createElement(name); made.textContent = text || ""; return made; };

  // [px] distance from the pointer to a mark that it means; marks closer together than the second are told together.
  var NEAR = 24, SAME = 2, MOST = 6;
  var source = document.getElementById("told"), told = source ? JSON.parse(source.textContent) : {};
  var tip = element("div");
  tip.className = "tip";
  tip.hidden = true;
  document.body.appendChild(tip);

  function tellOf(svg) {
    var marks = all("g[data-run]", svg).map(function (mark) {
      var series = mark.parentNode.closest("g[data-series]");
      return { run: mark.getAttribute("data-run"), group: mark, series: series, box: null };
    });
    var ring = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    ring.setAttribute("class", "ring hidden");
    ring.setAttribute("r", "75");
    svg.appendChild(ring);
    var middle = function (mark) {
      if (!mark.box) {
        var box = mark.group.getBBox();
        mark.box = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
      }
      return mark.box;
    };
    // Curves without marks: all corners, found when they are first needed.
    var curves = null;
    function corners() {
      curves = curves || all("g[data-series]", svg).filter(function (group) { return told[group.getAttribute("data-series")]; }).map(function (group) {
        var points = [];
        all("polyline", group).forEach(function (line) { points = points.concat(Array.prototype.slice.call(line.points)); });
        return { run: group.getAttribute("data-series"), series: group, points: points };
      });
      return curves;
    }
    // The point of a curve next to another point, between two corners if need be.
    function nearest(points, x, y) {
      return points.reduce(function (best, b, i) {
        var a = points[Math.max(i - 1, 0)], dx = b.x - a.x, dy = b.y - a.y, length = dx * dx + dy * dy;
        var share = length ? Math.max(0, Math.min(1, ((x - a.x) * dx + (y - a.y) * dy) / length)) : 0;
        var at = { x: a.x + share * dx, y: a.y + share * dy };
        at.off = Math.hypot(at.x - x, at.y - y);
        return !best || at.off < best.off ? at : best;
      }, null);
    }
    function hide() { tip.hidden = true; ring.classList.add("hidden"); }
    function show(event) {
      var matrix = svg.getScreenCTM();
      if (!matrix || !matrix.a) { return; }
      var x = (event.clientX - matrix.e) / matrix.a, y = (event.clientY - matrix.f) / matrix.d;
      var off = function (mark) { var at = middle(mark); return Math.hypot(at.x - x, at.y - y) * matrix.a; };
      var seen = marks.filter(function (mark) { return !(mark.series && mark.series.classList.contains("hidden")); });
      if (!marks.length) {
        seen = corners().filter(function (curve) { return !curve.series.classList.contains("hidden"); });
        seen.forEach(function (curve) { curve.box = nearest(curve.points, x, y); });
        seen = seen.filter(function (curve) { return curve.box; });
      }
      var best = seen.reduce(function (best, mark) { return !best || off(mark) < off(best) ? mark : best; }, null);
      if (!best || off(best) > NEAR) { hide(); return; }
      var at = middle(best);
      var runs = {};
      var here = seen.filter(function (mark) {
        var m = middle(mark), near = Math.hypot(m.x - at.x, m.y - at.y) * matrix.a <= SAME, first = near && !runs[mark.run];
        if (near) { runs[mark.run] = true; }
        return first;
      });
      tip.textContent = "";
      here.slice(0, MOST).forEach(function (mark) {
        var list = element("dl");
        (told[mark.run] || []).forEach(function (pair) {
          list.appendChild(element("dt", pair[0]));
          list.appendChild(element("dd", pair[1]));
        });
        tip.appendChild(list);
      });
      if (here.length > MOST) { tip.appendChild(element("p", "and " + (here.length - MOST) + " more here")); }
      ring.setAttribute("cx", at.x);
      ring.setAttribute("cy", at.y);
      ring.classList.remove("hidden");
      tip.hidden = false;
      var left = matrix.e + at.x * matrix.a, top = matrix.f + at.y * matrix.d;
      var size = tip.getBoundingClientRect(), width = document.documentElement.clientWidth;
      var beside = left + 14 + size.width <= width - 8 ? left + 14 : Math.max(8, Math.min(left - 14 - size.width, width - 8 - size.width));
      tip.style.left = beside + "px";
      tip.style.top = (top - size.height - 14 > 8 ? top - size.height - 14 : top + 14) + "px";
    }
    svg.addEventListener("pointermove", show);
    svg.addEventListener("pointerdown", show);
    svg.addEventListener("pointerleave", function (event) { if (event.pointerType !== "touch") { hide(); } });
    document.addEventListener("keydown", function (event) { if (event.key === "Escape") { hide(); } });
    window.addEventListener("scroll", hide, { passive: true });
  }
  all("figure svg").forEach(tellOf);

  // A legend within a figure is that figure's, another one is that of all figures.
  var switches = all(".legend button[data-switch]");
  function turn(button, on) {
    button.setAttribute("aria-pressed", String(on));
    all("g[data-series]", button.closest("figure")).forEach(function (group) {
      if (group.getAttribute("data-series") === button.getAttribute("data-switch")) { group.classList.toggle("hidden", !on); }
    });
  }
  switches.forEach(function (button) {
    button.addEventListener("click", function () { turn(button, button.getAttribute("aria-pressed") !== "true"); });
  });
  all(".legend button.all").forEach(function (button) {
    button.addEventListener("click", function () {
      var own = all("button[data-switch]", button.parentNode);
      var on = own.some(function (one) { return one.getAttribute("aria-pressed") !== "true"; });
      own.forEach(function (one) { turn(one, on); });
    });
  });

  // One of several pictures of a figure.
  all("figure .choose").forEach(function (line) {
    var menu = line.querySelector("select"), choices = all(".choice", line.closest("figure"));
    var choose = function () {
      choices.forEach(function (one, i) { one.classList.toggle("hidden", i !== menu.selectedIndex); });
    };
    line.classList.remove("hidden");
    menu.addEventListener("change", choose);
    choose();
  });

  // Columns sort on a click.
  all("table.runs").forEach(function (table) {
    var body = table.tBodies[0];
    Array.prototype.forEach.call(table.tHead.rows[0].cells, function (head, column) {
      var button = element("button", head.textContent), up = false;
      head.textContent = "";
      head.appendChild(button);
      button.addEventListener("click", function () {
        up = !up;
        var key = function (row) { var n = row.cells[column].getAttribute("data-sort"); return n === null ? null : Number(n); };
        Array.prototype.slice.call(body.rows).sort(function (a, b) {
          var x = key(a), y = key(b), order;
          if (x !== null && y !== null) { order = x - y; }
          else if (x !== null || y !== null) { return x === null ? 1 : -1; }
          else {
            var s = a.cells[column].textContent, t = b.cells[column].textContent;
            if (!s !== !t) { return s ? -1 : 1; }
            order = s < t ? -1 : s > t ? 1 : 0;
          }
          return up ? order : -order;
        }).forEach(function (row) { body.appendChild(row); });
      });
    });
  });
})();
