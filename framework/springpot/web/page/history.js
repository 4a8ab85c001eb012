// Where the user has been: branches, each a list of states of which one is shown. Undo goes back in the list.

const NAMES = "ABCDEFGHIJKL";

export const sameState = (one, other) => JSON.stringify(one) === JSON.stringify(other);

export class History {
  constructor(given) {
    this.branches = given?.branches || [];
    this.at = given?.branch || 0;
  }

  get branch() {
    return this.branches[this.at];
  }

  get state() {
    return this.branch ? this.branch.states[this.branch.at] : null;
  }

  // A new state; what was undone before is forgotten.
  push(state) {
    if (!this.branch) {
      this.branches.push({ name: NAMES[0], states: [state], at: 0 });
      return;
    }
    if (sameState(state, this.state)) return;
    const { branch } = this;
    branch.states = [...branch.states.slice(0, branch.at + 1), state].slice(-200);
    branch.at = branch.states.length - 1;
  }

  get canUndo() {
    return Boolean(this.branch) && this.branch.at > 0;
  }

  get canRedo() {
    return Boolean(this.branch) && this.branch.at < this.branch.states.length - 1;
  }

  undo() {
    if (this.canUndo) this.branch.at -= 1;
  }

  redo() {
    if (this.canRedo) this.branch.at += 1;
  }

  // A second way from a state, such as a rung of the present ladder; the first one stays as it is.
  fork(state) {
    if (this.branches.length === NAMES.length) return;
    const name = [...NAMES].find((letter) => this.branches.every((branch) => branch.name !== letter));
    this.branches.push({ name, states: [state], at: 0 });
    this.at = this.branches.length - 1;
  }

  drop(i) {
    if (this.branches.length === 1) return;
    this.branches.splice(i, 1);
    this.at = Math.min(this.at, this.branches.length - 1);
  }

  // The branch that is held beside the present one.
  get beside() {
    if (this.branches.length < 2) return null;
    return this.branches[this.at === 0 ? 1 : this.at - 1];
  }

  // Data have grown: each state is of these from now on, and the rows that it leaves out stand elsewhere.
  moved(before, data, rows) {
    const there = (state) => ({ ...state, data, excluded: state.excluded.map((row) => rows[row]).filter((row) => row !== null) });
    for (const branch of this.branches) branch.states = branch.states.map((state) => (state.data === before ? there(state) : state));
  }

  toJSON() {
    return { branches: this.branches, branch: this.at };
  }
}
