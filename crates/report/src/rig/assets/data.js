// The rig of the page.
const RIG = kinematicsOf(JSON.parse(document.getElementById("rig-data").textContent));
const { first: FIRST, ofBody: OF_BODY, values, given, solve, axisOf, pointsOf } = RIG;
