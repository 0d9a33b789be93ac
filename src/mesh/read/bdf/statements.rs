//! What is done with the bulk data entries of Nastran.
//!
//! Source: MSC Nastran Quick Reference Guide, "Bulk Data Entries".

use crate::read::statements::Meaning::{LeftOut, Nothing, Read, Refused};
use crate::read::statements::{JOINS, ONE_FILE, Statements, WRITE_OUT};

const SOLIDS: &str = "only lines, triangles and quads of first order are read; write the surface mesh alone";
const SUPERELEMENTS: &str = "superelements are not read; write the mesh as one residual structure";

pub(super) const ENTRIES: Statements = Statements {
    mark: "",
    list: &[
        (
            Read,
            &[
                "GRID", "GRDSET", "CTRIA3", "CTRIAR", "CQUAD4", "CQUADR", "CROD", "CBAR", "CBEAM", "CTUBE", "CONROD",
                "PLOTEL", "CBUSH", "CBUSH1D", "CVISC", "CGAP", "CELAS1", "CELAS2", "CDAMP1", "CDAMP2", "CONM1",
                "CONM2", "CMASS1", "CMASS2",
            ],
        ),
        (Refused(ONE_FILE), &["INCLUDE*"]),
        (
            Refused(WRITE_OUT),
            &[
                "=*", "*(*", "GRIDB", "GRIDF", "GRIDS", "GRIDA", "SPOINT", "GMCURV", "GMSURF", "RINGAX", "POINTAX",
                "EGRID",
            ],
        ),
        (
            Refused(SUPERELEMENTS),
            &["SEBULK", "SECONCT", "SEELT", "SEEXCLD", "SELOC", "SEMPLN", "SETREE", "SEEXCLUD", "RELEASE"],
        ),
        (
            Refused(JOINS),
            &[
                "RBE*", "RBAR*", "RROD", "RJOINT", "RSPLINE", "RSSCON", "RTRPLT*", "RIGID*", "MPC", "MPCADD", "CFAST",
                "CWELD", "CSEAM", "CCONCT", "CBJOIN", "BCTABL*", "CYJOIN",
            ],
        ),
        // Names of elements begin with C.
        (Refused(SOLIDS), &["C*", "PLOTEL3", "PLOTEL4", "PLOTTRI", "PLOTQUAD"]),
        (
            Nothing,
            &[
                "CORD*", "CHBDY*", "CONV*", "CAERO*", "CSSCHD", "CREEP", "CLOAD", "CSUPER", "CSUPEXT", "CYAX", "CYSUP",
                "CSET*", "COMBSC*", "CTRACK",
            ],
        ),
        (LeftOut, &["SET1", "SET2", "SET3", "ASSIGN"]),
        (
            Nothing,
            &[
                "MAT*", "PSHELL", "PCOMP*", "PROD", "PBAR*", "PBEAM*", "PTUBE", "PBUSH*", "PELAS*", "PDAMP*", "PVISC",
                "PGAP", "PMASS", "PSOLID", "PLPLANE", "PSHEAR", "PAERO*", "PLOAD*", "PARAM", "PFAST", "PWELD",
                "PLSOLID", "PSHLN*", "PSLDN*", "SPC*", "SUPORT*", "FORCE*", "MOMENT*", "GRAV", "LOAD*", "TLOAD*",
                "RLOAD*", "DLOAD", "DAREA", "DELAY", "DPHASE", "TEMP*", "EIG*", "TABLE*", "TSTEP*", "TIC", "NLPARM*",
                "NLPCI", "NLSTEP", "FREQ*", "ASET*", "BSET*", "OMIT*", "QSET*", "USET*", "DESVAR", "DCONSTR", "DRESP*",
                "DVPREL*", "DLINK", "DEQATN", "DOPTPRM", "DMI*", "DTI", "ECHO*", "AERO*", "SPLINE*", "FLFACT",
                "FLUTTER", "MKAERO*", "TRIM*", "GUST", "BCONP", "BCBODY*", "BCPARA", "BLSEG", "BSURF*", "BCPROP*",
                "RFORCE", "ACCEL*", "DEFORM", "NOLIN*", "SNORM", "BAROR", "BEAMOR", "LSEQ", "RANDPS", "RADM*", "VIEW*",
                "QBDY*", "QVOL", "QHBDY", "SLOAD", "SESET*", "SECSET*", "SEBSET*", "SEQSET*", "SENQSET", "SUPAX",
                "TOPVAR", "MONPNT*", "MDLPRM", "NLDAMP", "DMIG*", "ENDT",
            ],
        ),
    ],
};
