// The rod of the run that is kept to compare with, pale, behind the rod itself.

const WIDE = 4; // pixels
const PALE = 0.35;

// `joints` in metres from the origin of the state: x0, y0, ...; none where it is not there now.
export function ghost(context, camera, joints, colours) {
  if (!joints?.length) return;
  context.save();
  context.globalAlpha = PALE;
  context.strokeStyle = colours.ink;
  context.lineWidth = WIDE;
  context.lineCap = context.lineJoin = "round";
  context.beginPath();
  for (let at = 0; at < joints.length; at += 2) {
    context.lineTo(...camera.screen(joints[at], joints[at + 1]));
  }
  context.stroke();
  context.restore();
}
