/* isa.h - the same source compiled for several vector units in one program.
 *
 * A host build compiles integrator.c, block.c, drive.c, drive_block.c and ensemble.c once plainly (one lane, as on a target) and once for each vector
 * unit with -DKELLY_ISA=name; the external names of those copies get the name as a suffix. host/engine.c picks the
 * widest unit that the processor has. A target build has no KELLY_ISA and no suffix.
 */
#ifndef KELLY_ISA_H
#define KELLY_ISA_H

#ifndef KELLY_ISA
#define KELLY_ISA_NAME "scalar"
#define kelly_engine_here kelly_engine_scalar
#else
#define KELLY_JOIN2(name, isa) name##_##isa
#define KELLY_JOIN(name, isa) KELLY_JOIN2(name, isa)
#define KELLY_QUOTE2(isa) #isa
#define KELLY_QUOTE(isa) KELLY_QUOTE2(isa)
#define KELLY_ISA_NAME KELLY_QUOTE(KELLY_ISA)
#define kelly_block_clear KELLY_JOIN(kelly_block_clear, KELLY_ISA)
#define kelly_block_load KELLY_JOIN(kelly_block_load, KELLY_ISA)
#define kelly_block_advance KELLY_JOIN(kelly_block_advance, KELLY_ISA)
#define kelly_block_resync KELLY_JOIN(kelly_block_resync, KELLY_ISA)
#define kelly_block_strays KELLY_JOIN(kelly_block_strays, KELLY_ISA)
#define kelly_block_watch KELLY_JOIN(kelly_block_watch, KELLY_ISA)
#define kelly_block_speed KELLY_JOIN(kelly_block_speed, KELLY_ISA)
#define kelly_block_extremes KELLY_JOIN(kelly_block_extremes, KELLY_ISA)
#define kelly_block_modal KELLY_JOIN(kelly_block_modal, KELLY_ISA)
#define kelly_block_twist KELLY_JOIN(kelly_block_twist, KELLY_ISA)
#define kelly_block_sane KELLY_JOIN(kelly_block_sane, KELLY_ISA)
#define kelly_block_sine KELLY_JOIN(kelly_block_sine, KELLY_ISA)
#define kelly_block_seal KELLY_JOIN(kelly_block_seal, KELLY_ISA)
#define kelly_block_untouched KELLY_JOIN(kelly_block_untouched, KELLY_ISA)
#define kelly_driven_clear KELLY_JOIN(kelly_driven_clear, KELLY_ISA)
#define kelly_driven_load KELLY_JOIN(kelly_driven_load, KELLY_ISA)
#define kelly_driven_advance KELLY_JOIN(kelly_driven_advance, KELLY_ISA)
#define kelly_driven_strays KELLY_JOIN(kelly_driven_strays, KELLY_ISA)
#define kelly_driven_ramp KELLY_JOIN(kelly_driven_ramp, KELLY_ISA)
#define kelly_driven_adjust KELLY_JOIN(kelly_driven_adjust, KELLY_ISA)
#define kelly_driven_hold KELLY_JOIN(kelly_driven_hold, KELLY_ISA)
#define kelly_driven_weigh KELLY_JOIN(kelly_driven_weigh, KELLY_ISA)
#define kelly_driven_resync KELLY_JOIN(kelly_driven_resync, KELLY_ISA)
#define kelly_driven_outputs KELLY_JOIN(kelly_driven_outputs, KELLY_ISA)
#define kelly_driven_watch KELLY_JOIN(kelly_driven_watch, KELLY_ISA)
#define kelly_driven_speed KELLY_JOIN(kelly_driven_speed, KELLY_ISA)
#define kelly_driven_extremes KELLY_JOIN(kelly_driven_extremes, KELLY_ISA)
#define kelly_driven_modal KELLY_JOIN(kelly_driven_modal, KELLY_ISA)
#define kelly_driven_twist KELLY_JOIN(kelly_driven_twist, KELLY_ISA)
#define kelly_driven_sane KELLY_JOIN(kelly_driven_sane, KELLY_ISA)
#define kelly_driven_seal KELLY_JOIN(kelly_driven_seal, KELLY_ISA)
#define kelly_driven_untouched KELLY_JOIN(kelly_driven_untouched, KELLY_ISA)
#define kelly_driven_top_speed KELLY_JOIN(kelly_driven_top_speed, KELLY_ISA)
#define kelly_driven_top_torque KELLY_JOIN(kelly_driven_top_torque, KELLY_ISA)
#define kelly_run KELLY_JOIN(kelly_run, KELLY_ISA)
#define kelly_run_begin KELLY_JOIN(kelly_run_begin, KELLY_ISA)
#define kelly_run_advance KELLY_JOIN(kelly_run_advance, KELLY_ISA)
#define kelly_run_finish KELLY_JOIN(kelly_run_finish, KELLY_ISA)
#define kelly_run_draws KELLY_JOIN(kelly_run_draws, KELLY_ISA)
#define kelly_engine_here KELLY_JOIN(kelly_engine, KELLY_ISA)
#endif

#endif
