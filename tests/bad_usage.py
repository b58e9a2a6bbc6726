"""bad_usage.py - what the command line must refuse: exit 2 and one line, or exit 1 where a file cannot be written."""

MC, SIM = "montecarlo --samples 2 --duration 1 --window 0:1", "simulate --duration 1 --window 0:1"

USAGE = [
    "nonsense", "montecarlo nonsense", "montecarlo 'non\nsense'", f"{MC} --rpm '1\r\n2'", "montecarlo --nonsense 1", "simulate --samples 4", "modes --rpm 100", "modes --samples 3",
    "montecarlo --sample 3", "montecarlo --out x.csv", "simulate --csv x.csv", "simulate --convergence", "montecarlo -rpm 100", "montecarlo ''",
    "montecarlo --a-very-long-option-name-that-does-not-exist 1", "montecarlo --convergence=1", "modes --json",
    f"{MC} --rpm", f"{MC} --rpm=", f"{MC} --csv", f"{SIM} --out",
    *(f"{MC} {option} {value}" for option in ("--rpm", "--wob", "--mu", "--alpha1", "--alpha2", "--step", "--duration")
      for value in ("abc", "nan", "inf", "-inf", "1e400", "-1", "0", "1x", "0x", "1,5", "--seed")),
    *(f"{MC} --f0 {value}" for value in ("abc", "nan", "inf", "1e400", "-1")),
    *(f"{MC} --limit {value}" for value in ("abc", "nan", "-0.1", "11")),
    *(f"{SIM} --out-step {value}" for value in ("abc", "nan", "0", "-1", "0.00015", "1e400")),
    "montecarlo --window 50:101", "montecarlo --duration 10 --window 5:11", "montecarlo --window 60:50", "montecarlo --window 50:50",
    "montecarlo --window 50", "montecarlo --window :", "montecarlo --window 50:", "montecarlo --window :100", "montecarlo --window a:b",
    "montecarlo --window -1:10", "montecarlo --window nan:10", "montecarlo --window 0:inf", "montecarlo --window 0.00015:1",
    "montecarlo --window 0:1.0005", "montecarlo --window 1:2:3", "montecarlo --duration 0.0015", "montecarlo --duration 1e-6", "montecarlo --duration 1e8",
    "montecarlo --step 1e-7", "montecarlo --step 2", "montecarlo --step 0.0000010005", "montecarlo --step 0.0010000004", "montecarlo --step 0.0019999996", "montecarlo --step 0.003",
    *(f"{MC} --cov {value}" for value in ("-0.1", "0.6", "nan", "abc", "inf", "fc", "fc=", "fc=0.6", "fc=-0.1", "fc=nan", "xx=0.1", "fc=0.1,mu",
                                          "fc=0.1,xx=0.1", "=0.1", "0.1,0.2", "fc=0.1x", "fc=0.1,fc=0.2", "fc=0.1,,mu=0.1", "fc=0.1,")),
    *(f"montecarlo --samples {value}" for value in ("0", "-1", "abc", "1.5", "1e-3", "4294967296", "99999999999999999999", "+5")),
    *(f"{MC} --seed {value}" for value in ("-1", "abc", "1.5", "18446744073709551616", "nan")),
    *(f"{MC} --first {value}" for value in ("-1", "abc", "4294967296", "4294967295")),
    *(f"{MC} --threads {value}" for value in ("0", "-1", "abc", "1025", "1.5")),
    *(f"{MC} --torsional {value}" for value in ("0", "21", "-1", "abc", "2.5", "256", "266")),
    *(f"{MC} --axial {value}" for value in ("0", "12", "-1", "abc", "258")),
    *(f"{MC} --progress {value}" for value in ("loud", "JSON", "''")),
    *(f"{MC} --start {value}" for value in ("REST", "moving", "0", "''")),
    *(f"{command} --drive {value}" for command in (MC, SIM, "map --rpm 60 --wob 40 --samples 1 --duration 1 --window 0:1")
      for value in ("STIFF", "sof", "softer", "soft:", "soft:Z", "soft:Z=", "soft:Z=0", "soft:Z=-1", "soft:Z=nan", "soft:Z=1x", "soft:Z=1,,f=1", "soft:Z=1,Z=2",
                    "soft:J=0.5", "soft:J=1e10", "soft:f=0", "soft:f=101", "soft:q=1", "soft,Z=1", "stiff:Z=1", "soft:Z=1,", "''", "s" * 200)),
    *(f"rare --duration 1 --window 0:1 {args}" for args in ("--cov 0", "--samples-per-level 0", "--samples-per-level 2001", "--samples-per-level 960",
                                                            "--samples-per-level 1.5", "--samples-per-level", "--samples 10", "--first 1", "--csv x.csv",
                                                            "--convergence", "--limit -1", "--seed -1")),
    "simulate --drive soft:Z=1e6,J=1", "simulate --drive soft --rpm 2500",
    *(f"{MC} --engine {value}" for value in ("mmx", "AVX2", "''")),
    *(f"{SIM} --sample {value}" for value in ("-1", "abc", "1.5", "4294967296")),
    f"{MC} --csv - --json -", f"{MC} --csv same --json same",   # one would be lost in the other
    f"{MC} --csv a.csv --json ./a.csv", *(f"{MC} {more} --csv a --json a.{end}" for more in ("--convergence", "--envelope e.npy") for end in
                                          ("part", "journal", "convergence.journal", "envelope.journal", "journal.old")),
    f"{MC} --csv a.part --json a", f"{MC} --envelope a.npy --traces ./a.npy", f"{MC} --csv t.npy --traces t.npy",
    f"{SIM} --out a.csv --field ./a.csv", f"{SIM} --out a.csv.part --field a.csv", *(f"map --rpm 60 --wob 40 --samples 1 --duration 1 --window 0:1 {args}" for args in ("--csv m --npy ./m", "--json m --npy m.journal", "--npy - --json -")),
    "bench --port qemu:rv32 --csv b.csv --json b.csv.journal", "bench --port qemu:rv32 --mode lockstep --out b --json b",
    "bench --port qemu:rv32 --mode realtime --out b --wits ./b", "bench --port qemu:rv32 --mode lockstep --profile p.csv --out ./p.csv",
    f"{MC} --resume", f"{MC} --resume --csv -", f"{MC} --resume --json /dev/null", f"{MC} --resume=1 --csv x.csv", f"{SIM} --resume", "modes --resume",
    "sensitivity --resume", "advise --resume", "rare --resume", "map --resume", "merge", "merge --json x.json", "merge a.txt", "merge a.csv --threads 2",
    "rare --twice --csv x.csv --duration 2", "rare --twice --samples 5", "map --twice --start rotating", "advise --twice --convergence", "map --help=1",
    "merge nothing.csv", "plan --cores 0", "plan --cores 1e7", "plan --samples 0", "plan --csv x", "plan --lines maybe", "plan --message -1",
    "simulate --step 0.005", "simulate --wob 0.5", "simulate --wob 2000", "simulate --mu 1", "simulate --alpha1 100",
]

# {D}: a directory that does not exist; {F}: a directory of the test
FILES = [
    f"{MC} --json {{D}}/x.json", f"{MC} --csv {{D}}/x.csv", f"{SIM} --out {{D}}/x.csv", "modes --json {D}/x.json",
    *(f"{MC} --progress json --csv {{F}}/good.csv --{what} {{D}}/x.npy" for what in ("envelope", "traces")),   # told before anything runs
    f"{MC} --csv {{F}}/good.csv --json {{D}}/x.json", f"{MC} --json {{F}}", f"{MC} --csv {{F}}", f"{SIM} --out {{F}}",
]

# stdout is /dev/full
FULL = [f"{MC}", f"{MC} --csv -", f"{MC} --json -", f"{SIM}", f"{SIM} --out -", "modes", "modes --json -", "--help", "--version",
        f"{MC} --csv /dev/full", f"{MC} --json /dev/full", f"{SIM} --out /dev/full", "modes --json /dev/full"]
