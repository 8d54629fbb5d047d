// The most steps of all walks along one ray, in all media (stage/bounce). It is raised if the numerics probe finds no limit on loops.
override MOST_STEPS_OF_CROSSINGS: u32 = STEPS_OF_CROSSINGS;
